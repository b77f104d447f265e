#include "io/dds_subscriber.h"

#include <stillpoint_idl/stillpointPubSubTypes.h>

#include <atomic>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include "core/clock.h"
#include "io/dds_convert.h"
#include "io/dds_entities.h"

namespace stillpoint::io {
namespace {

using Code = eprosima::fastrtps::types::ReturnCode_t;

/// Takes what has arrived and hands it on; one wire message object a topic, reused.
template <class Wire, class Deliver>
class Listener : public dds::DataReaderListener {
 public:
  explicit Listener(Deliver deliver) : deliver_(std::move(deliver)) {}
  void on_data_available(dds::DataReader* reader) override {
    const std::int64_t t_receive_ns = monotonic_ns();
    dds::SampleInfo info;
    while (reader->take_next_sample(&message_, &info) == Code::RETCODE_OK)
      if (info.valid_data) deliver_(message_, t_receive_ns);
  }
  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    matched_.store(status.current_count, std::memory_order_relaxed);
  }
  [[nodiscard]] int matched() const { return matched_.load(std::memory_order_relaxed); }

 private:
  Deliver deliver_;
  Wire message_;
  std::atomic<int> matched_{0};
};

}  // namespace

struct DdsSubscriber::Impl {
  DdsHandlers handlers;
  std::vector<std::unique_ptr<dds::DataReaderListener>> listeners;
  std::vector<std::function<int()>> matched;
  std::unique_ptr<DdsEntities> entities;  // last: its end stops the callbacks before what they use goes

  template <class Wire, class Deliver>
  Result<void> subscribe(const std::string& topic, dds::TopicDataType* type, const dds::DataReaderQos& qos,
                         Deliver deliver) {
    const dds::TypeSupport support(type);
    auto listener = std::make_unique<Listener<Wire, Deliver>>(std::move(deliver));
    auto* raw = listener.get();
    listeners.push_back(std::move(listener));
    matched.emplace_back([raw] { return raw->matched(); });
    const auto reader = entities->reader(topic, support, qos, raw);
    if (!reader) return tl::unexpected(reader.error());
    return {};
  }
  Result<void> subscribe_all(const DdsParams& params);
};

Result<void> DdsSubscriber::Impl::subscribe_all(const DdsParams& params) {
  Result<void> done;
  if (handlers.attitude)
    done = subscribe<msg::Attitude>(params.attitude_topic, new Guarded<msg::AttitudePubSubType>,
                                    attitude_reader_qos(params.transport),
                                    [this](const msg::Attitude& in, std::int64_t t_receive_ns) {
                                      AttitudeMessage out;
                                      if (from_wire(in, out)) handlers.attitude(out, t_receive_ns);
                                    });
  if (done && handlers.raw && !params.raw_topic.empty())
    done = subscribe<msg::RawImu>(params.raw_topic, new Guarded<msg::RawImuPubSubType>,
                                  reliable_reader_qos(kRawDepth, false), [this](const msg::RawImu& in, std::int64_t) {
                                    RawSample out;
                                    if (from_wire(in, out)) handlers.raw(out, in.t_arrival_ns());
                                  });
  if (done && handlers.calibration)
    done = subscribe<msg::CalibrationState>(params.calibration_topic, new Guarded<msg::CalibrationStatePubSubType>,
                                            reliable_reader_qos(1, true),
                                            [this](const msg::CalibrationState& in, std::int64_t) {
                                              CalibrationMessage out;
                                              if (from_wire(in, out)) handlers.calibration(out);
                                            });
  if (done && handlers.diagnostics)
    done = subscribe<msg::Diagnostics>(params.diagnostics_topic, new Guarded<msg::DiagnosticsPubSubType>,
                                       reliable_reader_qos(1, true), [this](const msg::Diagnostics& in, std::int64_t) {
                                         DiagnosticsMessage out;
                                         from_wire(in, out);
                                         handlers.diagnostics(out);
                                       });
  return done;
}

DdsSubscriber::DdsSubscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DdsSubscriber::~DdsSubscriber() = default;

Result<std::unique_ptr<DdsSubscriber>> DdsSubscriber::create(const DdsParams& params, DdsHandlers handlers) {
  auto impl = std::make_unique<Impl>();
  impl->handlers = std::move(handlers);
  auto entities = DdsEntities::create(params, params.transport, "stillpoint subscriber");
  if (!entities) return tl::unexpected(entities.error());
  impl->entities = std::move(*entities);
  if (auto done = impl->subscribe_all(in_namespace(params)); !done) return tl::unexpected(done.error());
  return std::unique_ptr<DdsSubscriber>(new DdsSubscriber(std::move(impl)));
}

int DdsSubscriber::publishers() const {
  int sum = 0;
  for (const auto& matched : impl_->matched) sum += matched();
  return sum;
}

}  // namespace stillpoint::io
