// Another maker's DDS as a ROS 2 node would use it, for the end-to-end test: it reads what the bridge publishes and compares
// each message's bytes with those that Fast DDS's own types make of it, or publishes what the bridge takes.
//
// As with ROS 2, ROS_LOCALHOST_ONLY=0 is for more than this machine; here it is 1 unless said.
//
// usage: ros2_peer read DOMAIN NAMESPACE SECONDS [crtk] [best_effort]  prints a line of JSON for each topic, poses before it
//        ros2_peer move DOMAIN NAMESPACE OBJECT HZ SECONDS MOTION      MOTION: circle, nan, zero_rotation, frame
//        ros2_peer add DOMAIN TOPIC X Y Z HZ SECONDS [FRAME]           a force
//        ros2_peer call DOMAIN SERVICE CALLER SCENE [TIMES]            an edit; prints each reply that comes
//        ros2_peer disturb DOMAIN NAMESPACE SECONDS                    publishes other types under the bridge's topics

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "ros2_messagesPubSubTypes.h"

namespace {

namespace dds = eprosima::fastdds::dds;
using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;
using Clock = std::chrono::steady_clock;

/// Type is a generated one. Notes where the bytes that come are not those that Type writes.
template <class Type>
class Compared : public Type {
 public:
  static std::atomic<unsigned long> differing;

  bool deserialize(Payload* payload, void* data) override {
    if (!Type::deserialize(payload, data)) return ++differing, false;
    Payload own(payload->length + 64);
    std::memset(own.data, 0, own.max_size);
    if (!Type::serialize(data, &own)) return ++differing, false;
    constexpr std::uint32_t kHead = 4, kMaxPadding = 3;  // kind, options
    const bool same = own.length >= kHead && payload->length >= own.length &&
                      payload->length - own.length <= kMaxPadding && payload->data[0] == 0 &&
                      payload->data[1] == CDR_LE &&
                      std::memcmp(own.data + kHead, payload->data + kHead, own.length - kHead) == 0;
    if (!same) ++differing;
    return true;
  }
};
template <class Type>
std::atomic<unsigned long> Compared<Type>::differing{0};

void print(const geometry_msgs::msg::dds_::PoseStamped_& m, const std::string& topic) {
  std::printf("{\"pose_of\": \"%s\", \"stamp_ns\": %lld, \"frame\": \"%s\", \"at\": [%.17g, %.17g, %.17g]}\n",
              topic.c_str(), m.header().stamp().sec() * 1'000'000'000LL + m.header().stamp().nanosec(),
              m.header().frame_id().c_str(), m.pose().position().x(), m.pose().position().y(), m.pose().position().z());
}
void print(const geometry_msgs::msg::dds_::WrenchStamped_& m, const std::string& topic) {
  std::printf("{\"wrench_of\": \"%s\", \"stamp_ns\": %lld, \"force\": [%.17g, %.17g, %.17g]}\n", topic.c_str(),
              m.header().stamp().sec() * 1'000'000'000LL + m.header().stamp().nanosec(), m.wrench().force().x(),
              m.wrench().force().y(), m.wrench().force().z());
}
void print(const geometry_msgs::msg::dds_::TwistStamped_& m, const std::string& topic) {
  std::printf("{\"twist_of\": \"%s\", \"stamp_ns\": %lld, \"linear\": [%.17g, %.17g, %.17g]}\n", topic.c_str(),
              m.header().stamp().sec() * 1'000'000'000LL + m.header().stamp().nanosec(), m.twist().linear().x(),
              m.twist().linear().y(), m.twist().linear().z());
}
void print(const sensor_msgs::msg::dds_::Joy_&, const std::string&) {}
void print(const sensor_msgs::msg::dds_::JointState_& m, const std::string& topic) {
  std::printf("{\"joint_of\": \"%s\", \"name\": \"%s\", \"position\": %.17g}\n", topic.c_str(), m.name().at(0).c_str(),
              m.position().at(0));
}
void print(const std_msgs::msg::dds_::String_& m, const std::string& topic) {
  std::printf("{\"text_of\": \"%s\", \"text\": \"%s\"}\n", topic.c_str(), m.data().c_str());
}
void print(const tf2_msgs::msg::dds_::TFMessage_& m, const std::string& topic) {
  for (const auto& t : m.transforms())
    std::printf("{\"frame_of\": \"%s\", \"frame\": \"%s\", \"at\": [%.17g, %.17g, %.17g]}\n", topic.c_str(),
                t.child_frame_id().c_str(), t.transform().translation().x(), t.transform().translation().y(),
                t.transform().translation().z());
}
void print(const visualization_msgs::msg::dds_::MarkerArray_& m, const std::string& topic) {
  for (const auto& marker : m.markers())
    std::printf(
        "{\"marker_of\": \"%s\", \"object\": \"%s\", \"frame\": \"%s\", \"action\": %d, \"type\": %d, \"points\": "
        "%zu}\n",
        topic.c_str(), marker.ns().c_str(), marker.header().frame_id().c_str(), static_cast<int>(marker.action()),
        static_cast<int>(marker.type()), marker.points().size());
}

class Node {
 public:
  explicit Node(unsigned domain) {
    dds::DomainParticipantQos qos;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    const char* const localhostOnly = std::getenv("ROS_LOCALHOST_ONLY");
    if (localhostOnly == nullptr || std::string(localhostOnly) != "0")
      udp->interfaceWhiteList.emplace_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    if (participant_ == nullptr) throw std::runtime_error("no participant");
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
  }
  ~Node() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  /// @param topic  As ROS 2 has it; of a service, as DDS has it.
  template <class Type>
  dds::DataReader* read(const std::string& topic, bool reliable, bool transientLocal,
                        dds::DataReaderListener* listener) {
    dds::DataReaderQos qos;
    qos.reliability().kind = reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = transientLocal ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 5000;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return subscriber_->create_datareader(makeTopic<Compared<Type>>(topic), qos, listener);
  }
  template <class Type>
  dds::DataWriter* write(const std::string& topic) {
    dds::DataWriterQos qos;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return publisher_->create_datawriter(makeTopic<Type>(topic), qos);
  }

 private:
  dds::DomainParticipant* participant_;
  dds::Subscriber* subscriber_;
  dds::Publisher* publisher_;

  template <class Type>
  dds::Topic* makeTopic(const std::string& topic) {
    const dds::TypeSupport type(new Type);
    type.register_type(participant_);
    auto* made = participant_->create_topic(topic[0] == '/' ? "rt" + topic : topic, type.get_type_name(),
                                            dds::TOPIC_QOS_DEFAULT);
    if (made == nullptr) throw std::runtime_error("no topic " + topic);
    return made;
  }
};

class Listener : public dds::DataReaderListener {
 public:
  virtual void report() const = 0;
  [[nodiscard]] virtual bool isMatched() const = 0;
};

template <class Type>
class Counter : public Listener {
 public:
  Counter(std::string topic, Clock::time_point began) : topic_(std::move(topic)), began_(began) {}

  void on_subscription_matched(dds::DataReader*, const dds::SubscriptionMatchedStatus& status) override {
    if (status.current_count > 0 && matched_ms_ < 0) matched_ms_ = elapsed_ms();
  }
  void on_data_available(dds::DataReader* reader) override {
    typename Type::type message;
    dds::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      if (count_ == 0) first_ms_ = elapsed_ms();
      ++count_;
      const auto number = static_cast<long long>(info.sample_identity.sequence_number().to64long());
      if (last_ == 0) first_ = number;
      if (last_ != 0 && number <= last_) ++outOfOrder_;
      if (last_ != 0 && number > last_ + 1) lost_ += number - last_ - 1;
      last_ = number;
      print(message, topic_);
      if (count_ == 1) std::fflush(stdout);
    }
  }
  void report() const override {
    std::printf(
        "{\"topic\": \"%s\", \"count\": %lu, \"first\": %lld, \"lost\": %lld, \"out_of_order\": %lu, \"differing\": "
        "%lu, "
        "\"matched_ms\": %.0f, "
        "\"first_ms\": %.0f}\n",
        topic_.c_str(), count_, first_, lost_, outOfOrder_, Compared<Type>::differing.load(), matched_ms_.load(),
        first_ms_);
  }
  [[nodiscard]] bool isMatched() const override { return matched_ms_ >= 0; }

 private:
  std::string topic_;
  Clock::time_point began_;
  unsigned long count_ = 0, outOfOrder_ = 0;
  long long first_ = 0, last_ = 0, lost_ = 0;  // numbers of the writer
  std::atomic<double> matched_ms_ = -1;
  double first_ms_ = -1;

  [[nodiscard]] double elapsed_ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - began_).count();
  }
};

void read(const std::vector<std::string>& arguments) {
  const std::string& name = arguments.at(2);
  bool crtk = false, reliable = true;
  for (std::size_t i = 4; i < arguments.size(); ++i) {
    crtk |= arguments[i] == "crtk";
    reliable &= arguments[i] != "best_effort";
  }
  // Whoever reads what is said may be held up for longer than messages are kept.
  static std::array<char, std::size_t{64} << 20> unsaid;  // flushed at the end, and so without a destructor
  std::setvbuf(stdout, unsaid.data(), _IOFBF, unsaid.size());
  const auto began = Clock::now();
  std::vector<std::unique_ptr<Listener>> listeners;
  Node node(static_cast<unsigned>(std::stoul(arguments.at(1))));
  const auto add = [&]<class Type>(const std::string& topic, bool ticks, bool late, Type*) {
    auto counter = std::make_unique<Counter<Type>>(topic, began);
    node.read<Type>(topic, !ticks || reliable, late, counter.get());
    listeners.push_back(std::move(counter));
  };
  using namespace geometry_msgs::msg::dds_;
  add(name + (crtk ? "/measured_cp" : "/pose"), true, false, static_cast<PoseStamped_PubSubType*>(nullptr));
  add(name + "/ihip", true, false, static_cast<PoseStamped_PubSubType*>(nullptr));
  add(name + (crtk ? "/measured_cv" : "/twist"), true, false, static_cast<TwistStamped_PubSubType*>(nullptr));
  add(name + (crtk ? "/measured_cf" : "/wrench"), true, false, static_cast<WrenchStamped_PubSubType*>(nullptr));
  add(name + "/contact", true, false, static_cast<WrenchStamped_PubSubType*>(nullptr));
  add(name + "/joy", true, false, static_cast<sensor_msgs::msg::dds_::Joy_PubSubType*>(nullptr));
  add(name + (crtk ? "/gripper/measured_js" : "/gripper"), true, false,
      static_cast<sensor_msgs::msg::dds_::JointState_PubSubType*>(nullptr));
  add(name + "/touched", false, true, static_cast<std_msgs::msg::dds_::String_PubSubType*>(nullptr));
  add("/tf", false, false, static_cast<tf2_msgs::msg::dds_::TFMessage_PubSubType*>(nullptr));
  add("/tf_static", false, true, static_cast<tf2_msgs::msg::dds_::TFMessage_PubSubType*>(nullptr));
  // As RViz does unless told otherwise.
  add(name + "/scene", false, false, static_cast<visualization_msgs::msg::dds_::MarkerArray_PubSubType*>(nullptr));
  constexpr std::chrono::seconds kPatience{60};
  while (!listeners.front()->isMatched() && Clock::now() < began + kPatience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(std::stod(arguments.at(3))));
  for (const auto& listener : listeners) listener->report();
}

void move(const std::vector<std::string>& arguments) {
  Node node(static_cast<unsigned>(std::stoul(arguments.at(1))));
  auto* writer = node.write<tf2_msgs::msg::dds_::TFMessage_PubSubType>(arguments.at(2) + "/set_objects");
  const std::string& motion = arguments.at(6);
  const double rate_Hz = std::stod(arguments.at(4)), seconds = std::stod(arguments.at(5));
  tf2_msgs::msg::dds_::TFMessage_ message;
  message.transforms().resize(1);
  auto& given = message.transforms()[0];
  given.child_frame_id(arguments.at(3));
  given.header().frame_id(motion == "frame" ? "base_link" : "world");
  given.transform().rotation().w(motion == "zero_rotation" ? 0 : 1);
  const auto began = Clock::now();
  for (double t = 0; t < seconds; t += 1 / rate_Hz) {
    std::this_thread::sleep_until(began +
                                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(t)));
    given.transform().translation().x(motion == "nan" ? std::numeric_limits<double>::quiet_NaN()
                                                      : 0.05 * std::cos(3 * t));
    given.transform().translation().y(0.05 * std::sin(3 * t));
    given.transform().translation().z(0.025);
    writer->write(&message);
  }
}

void add(const std::vector<std::string>& arguments) {
  Node node(static_cast<unsigned>(std::stoul(arguments.at(1))));
  auto* writer = node.write<geometry_msgs::msg::dds_::WrenchStamped_PubSubType>(arguments.at(2));
  geometry_msgs::msg::dds_::WrenchStamped_ message;
  message.header().frame_id(arguments.size() > 8 ? arguments[8] : "world");
  auto& force = message.wrench().force();
  force.x(std::stod(arguments.at(3)));
  force.y(std::stod(arguments.at(4)));
  force.z(std::stod(arguments.at(5)));
  const double rate_Hz = std::stod(arguments.at(6)), seconds = std::stod(arguments.at(7));
  const auto began = Clock::now();
  for (double t = 0; t < seconds; t += 1 / rate_Hz) {
    std::this_thread::sleep_until(began +
                                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(t)));
    writer->write(&message);
  }
}

class Replies : public dds::DataReaderListener {
 public:
  void on_data_available(dds::DataReader* reader) override {
    haptics_msgs::srv::dds_::Edit_Response_ reply;
    dds::SampleInfo info;
    while (reader->take_next_sample(&reply, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      // The words of a reply quote what was asked for.
      std::string words = reply.message();
      for (char& c : words) c = c == '"' || c == '\\' || c == '\n' ? ' ' : c;
      std::printf(
          "{\"caller\": %llu, \"number\": %lld, \"success\": %s, \"message\": \"%s\", \"revision\": %llu, \"tick\": "
          "%llu, "
          "\"differing\": %lu}\n",
          static_cast<unsigned long long>(reply.caller()), static_cast<long long>(reply.number()),
          reply.success() ? "true" : "false", words.c_str(), static_cast<unsigned long long>(reply.revision()),
          static_cast<unsigned long long>(reply.tick()),
          Compared<haptics_msgs::srv::dds_::Edit_Response_PubSubType>::differing.load());
      ++came;
    }
  }
  std::atomic<int> came{0};
};

void call(const std::vector<std::string>& arguments) {
  constexpr std::chrono::seconds kPatience{20};
  using namespace haptics_msgs::srv::dds_;
  Replies replies;
  Node node(static_cast<unsigned>(std::stoul(arguments.at(1))));
  auto* reader = node.read<Edit_Response_PubSubType>("rr" + arguments.at(2) + "Reply", true, false, &replies);
  auto* writer = node.write<Edit_Request_PubSubType>("rq" + arguments.at(2) + "Request");
  const int times = arguments.size() > 5 ? std::stoi(arguments[5]) : 1;
  const auto end = Clock::now() + kPatience;
  const auto await = [end](const auto& isSo) {
    while (!isSo() && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  await([&] {
    dds::PublicationMatchedStatus to;
    dds::SubscriptionMatchedStatus from;
    writer->get_publication_matched_status(to);
    reader->get_subscription_matched_status(from);
    return to.current_count > 0 && from.current_count > 0;
  });
  std::this_thread::sleep_for(std::chrono::seconds(1));  // the bridge finds this side a moment later
  Edit_Request_ request;
  request.caller(std::stoull(arguments.at(3)));
  request.scene(arguments.at(4));
  for (int i = 0; i < times; ++i) {
    request.number(i + 1);
    writer->write(&request);
    await([&] { return replies.came > i; });
  }
}

void disturb(const std::vector<std::string>& arguments) {
  const std::string& name = arguments.at(2);
  Node node(static_cast<unsigned>(std::stoul(arguments.at(1))));
  auto* poses = node.write<std_msgs::msg::dds_::String_PubSubType>(name + "/set_objects");
  auto* wrench = node.write<std_msgs::msg::dds_::String_PubSubType>(name + "/add_wrench");
  auto* pose = node.write<geometry_msgs::msg::dds_::TwistStamped_PubSubType>(name + "/pose");
  auto* edit = node.write<std_msgs::msg::dds_::String_PubSubType>("rq" + name + "/editRequest");
  std_msgs::msg::dds_::String_ text;
  text.data(std::string(10'000, 'x'));
  geometry_msgs::msg::dds_::TwistStamped_ twist;
  const auto end = Clock::now() + std::chrono::duration<double>(std::stod(arguments.at(3)));
  while (Clock::now() < end) {
    poses->write(&text);
    wrench->write(&text);
    pose->write(&twist);
    edit->write(&text);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    const std::string& verb = arguments.at(0);
    if (verb == "read") return read(arguments), 0;
    if (verb == "move") return move(arguments), 0;
    if (verb == "add") return add(arguments), 0;
    if (verb == "call") return call(arguments), 0;
    if (verb == "disturb") return disturb(arguments), 0;
    std::fprintf(stderr, "ros2_peer: read, move, add, call or disturb\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_peer: %s\n", error.what());
  }
  return 1;
}
