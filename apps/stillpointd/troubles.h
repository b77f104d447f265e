/// What the daemon does without at the moment: the network, the disk, a right. It runs on, says so once, shows it in
/// the diagnostics and in `stillpoint status`, and says when it is over.
#pragma once
#include <map>
#include <mutex>
#include <string>

#include "apps/stillpointd/log.h"

namespace stillpoint::app {

/// Any thread but the sensor's.
class Troubles {
 public:
  /// `what` names the subject; an empty sentence: it is over.
  void set(const std::string& what, const std::string& sentence) {
    const std::lock_guard lock(mutex_);
    const auto now = by_subject_.find(what);
    if (sentence.empty() && now == by_subject_.end()) return;
    if (now != by_subject_.end() && now->second == sentence) return;
    log(sentence.empty() ? what + ": well again" : sentence);
    if (sentence.empty())
      by_subject_.erase(now);
    else
      by_subject_[what] = sentence;
  }
  /// All of them, separated by "; "; empty: none.
  [[nodiscard]] std::string all() const {
    const std::lock_guard lock(mutex_);
    std::string out;
    for (const auto& [what, sentence] : by_subject_) out += (out.empty() ? "" : "; ") + sentence;
    return out;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::string> by_subject_;
};

}  // namespace stillpoint::app
