#include "sources/ros2_source.h"

#include <stillpoint_idl/ros2PubSubTypes.h>

#include <atomic>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include "core/clock.h"
#include "io/dds_entities.h"
#include "sources/inbox.h"
#include "sources/ros2_convert.h"
#include "sources/stamps.h"

namespace stillpoint::sources {
namespace {

namespace dds = io::dds;
using Code = eprosima::fastrtps::types::ReturnCode_t;

constexpr int kDepth = 1024;  // a second at 1 kHz

template <class Message, class Convert>
class Listener : public dds::DataReaderListener {
 public:
  Listener(Inbox& inbox, std::atomic<int>& publishers, Convert convert)
      : inbox_(inbox), publishers_(publishers), convert_(std::move(convert)) {}
  void on_data_available(dds::DataReader* reader) override {
    const std::int64_t arrival_ns = monotonic_ns();
    dds::SampleInfo info;
    while (reader->take_next_sample(&message_, &info) == Code::RETCODE_OK) {
      const auto from = eprosima::fastrtps::rtps::iHandle2GUID(info.publication_handle);
      if (!info.valid_data || from.is_on_same_process_as(reader->guid())) continue;
      const Reading reading = convert_(message_);
      if (reading.sample.has != 0)
        inbox_.put(reading, arrival_ns);
      else
        inbox_.malformed.fetch_add(1, std::memory_order_relaxed);
    }
  }
  void on_subscription_matched(dds::DataReader* reader, const dds::SubscriptionMatchedStatus& status) override {
    const auto who = eprosima::fastrtps::rtps::iHandle2GUID(status.last_publication_handle);
    if (!who.is_on_same_process_as(reader->guid())) publishers_ += status.current_count_change;
  }
  void on_sample_lost(dds::DataReader*, const dds::SampleLostStatus& status) override {
    inbox_.skip(static_cast<std::uint64_t>(std::max(0, status.total_count_change)));
  }

 private:
  Inbox& inbox_;
  std::atomic<int>& publishers_;
  Convert convert_;
  Message message_;
};

}  // namespace

struct Ros2Source::Impl {
  Inbox inbox;
  std::atomic<int> publishers{0};
  Stamps stamps{0.0};
  ReportCell report = std::make_shared<SnapshotCell<SourceReport>>();
  SourceReport counts;
  std::int64_t told_ns = 0;
  bool was_there = false;
  std::vector<std::unique_ptr<dds::DataReaderListener>> listeners;
  std::unique_ptr<io::DdsEntities> entities;  // last: its end stops the callbacks before what they use goes

  template <class Message, class Convert>
  Result<void> listen(const std::string& topic, dds::TopicDataType* type, bool reliable, Convert convert) {
    const dds::TypeSupport support(type);
    if (topic.empty()) return {};
    dds::DataReaderQos qos = io::reliable_reader_qos(kDepth, false);
    if (!reliable) qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
    listeners.push_back(std::make_unique<Listener<Message, Convert>>(inbox, publishers, std::move(convert)));
    const auto reader = entities->reader(dds_topic(topic), support, qos, listeners.back().get());
    if (!reader) return tl::unexpected(reader.error());
    return {};
  }

  void tell(LinkState link) noexcept {
    counts.link = link;
    counts.malformed = inbox.malformed.load(std::memory_order_relaxed);
    counts.lost = inbox.lost.load(std::memory_order_relaxed);
    counts.began_anew = stamps.began_anew();
    counts.away_ns = stamps.away_ns();
    report->store(counts);
    told_ns = monotonic_ns();
  }

  /// A message speaks of its own sensors; what another said of the rest serves on.
  void hear_noise(const Reading& reading) noexcept {
    if (reading.sample.holds(kAcc)) counts.noise.acc_mps2 = reading.noise.acc_mps2;
    if (reading.sample.holds(kGyr)) counts.noise.gyr_radps = reading.noise.gyr_radps;
    if (reading.sample.holds(kMag)) counts.noise.mag_uT = reading.noise.mag_uT;
    if (reading.refused_variance == 0.0) return;
    ++counts.variances_refused;
    counts.refused_part = reading.refused_part;
    counts.refused_variance = reading.refused_variance;
  }

  bool take(pipeline::Arrival& out) noexcept {
    Inbox::Item item;
    while (inbox.take(item)) {
      if (!stamps.stamp(item.reading, item.arrival_ns, 1)) {
        ++counts.unstamped;
        continue;
      }
      hear_noise(item.reading);
      out.sample = item.reading.sample;
      out.arrival_ns = item.arrival_ns;
      out.noise = counts.noise;
      ++counts.readings;
      was_there = true;
      if (item.arrival_ns - told_ns > kTellPeriod_ns || counts.link != LinkState::kThere) tell(LinkState::kThere);
      return true;
    }
    return false;
  }
};

Ros2Source::Ros2Source(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Ros2Source::~Ros2Source() = default;
Ros2Source::Ros2Source(Ros2Source&&) noexcept = default;
Ros2Source& Ros2Source::operator=(Ros2Source&&) noexcept = default;

ReportCell Ros2Source::report() const noexcept { return impl_->report; }

Result<Ros2Source> Ros2Source::create(const io::Ros2Params& params, const io::DdsParams& dds) {
  auto impl = std::make_unique<Impl>();
  io::DdsParams wire = dds;
  if (params.domain >= 0) wire.domain = params.domain;
  auto entities = io::DdsEntities::create(wire, "udp", "stillpoint source");
  if (!entities) return tl::unexpected(entities.error());
  impl->entities = std::move(*entities);
  const bool use_covariance = params.use_covariance;
  auto done = impl->listen<sensor_msgs::msg::Imu>(
      params.imu_topic, new io::Guarded<sensor_msgs::msg::ImuPubSubType>, params.reliable,
      [use_covariance](const sensor_msgs::msg::Imu& message) { return from_ros2(message, use_covariance); });
  if (done)
    done = impl->listen<sensor_msgs::msg::MagneticField>(
        params.mag_topic, new io::Guarded<sensor_msgs::msg::MagneticFieldPubSubType>, params.reliable,
        [use_covariance](const sensor_msgs::msg::MagneticField& message) {
          return from_ros2(message, use_covariance);
        });
  if (!done) return tl::unexpected(done.error());
  impl->counts.error = ShortText("no publisher of " + dds_topic(params.imu_topic) + " was heard");
  impl->tell(LinkState::kNeverThere);
  return Ros2Source(std::move(impl));
}

pipeline::SourceState Ros2Source::next(pipeline::Arrival& out) noexcept {
  using pipeline::SourceState;
  if (impl_->take(out)) return SourceState::kSample;
  impl_->inbox.wait();
  if (impl_->take(out)) return SourceState::kSample;
  const bool there = impl_->publishers.load(std::memory_order_relaxed) > 0;
  if (!there && impl_->was_there && impl_->counts.link != LinkState::kGone) impl_->stamps.restart();
  impl_->tell(there ? impl_->counts.link : impl_->was_there ? LinkState::kGone : LinkState::kNeverThere);
  return !there && impl_->was_there ? SourceState::kGone : SourceState::kNothing;
}

}  // namespace stillpoint::sources
