#include "graphics_client/ros2/dds.h"

#include <dds/version.h>

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

namespace haptics::dds {
namespace {

/// Unacknowledged bytes that a writer holds before it refuses more. Not reached: a history of 2,000 is smaller, and the scene's
/// is of one message.
constexpr const char* kMaxUnacknowledged = "256 MB";

/// Bytes of a large message, or of what was lost, sent at once; the rest when the reader has those. More, or in many small packets,
/// overruns the usual buffer of a socket, 208 kB: what else comes is lost with it, and is to be sent again in turn.
constexpr const char* kMaxFirst = "65536";
constexpr const char* kMaxAgain = "16384 B";
/// Of one packet, on this machine; elsewhere, where a packet of several frames is lost with any of them.
constexpr const char* kMaxPacket = "14720 B";
constexpr const char* kMaxFrame = "1344 B";

// Ticks that come together are sent together. Cyclone DDS 0.10.5 has a policy for that, and warns of the setting.
#define HAPTICS_BATCHING_IS_A_POLICY (DDS_VERSION_MAJOR > 0 || DDS_VERSION_MINOR > 10 || DDS_VERSION_PATCH >= 5)
constexpr const char* kBatching = HAPTICS_BATCHING_IS_A_POLICY ? "" : "<WriteBatch>true</WriteBatch>";

/// How often readers are asked what they lack. More often: what is on its way is sent again, and they are overrun for good.
constexpr const char* kAsking =
    "<HeartbeatInterval min=\"50ms\" minsched=\"50ms\" max=\"1s\">100ms</HeartbeatInterval>";

std::string configuration(const std::string& settings) {
  return "<CycloneDDS><Domain>" + settings + "</Domain></CycloneDDS>";
}

/// Of interface, discovery and writing.
/// @param interface  Has been checked: it quotes nothing.
std::string settings(const std::string& interface, const std::string& users) {
  const std::string packet = interface.empty() && users.empty() ? kMaxPacket : kMaxFrame;
  const std::string writing = "<General><MaxMessageSize>" + packet + "</MaxMessageSize><MaxRexmitMessageSize>" +
                              packet + "</MaxRexmitMessageSize></General><Internal>" + kAsking + kBatching +
                              "<BurstSize><MaxInitTransmit>" + kMaxFirst + "</MaxInitTransmit><MaxRexmit>" + kMaxAgain +
                              "</MaxRexmit></BurstSize><Watermarks><WhcAdaptive>false</WhcAdaptive><WhcHigh>" +
                              kMaxUnacknowledged + "</WhcHigh></Watermarks></Internal>";
  if (!users.empty()) return configuration(writing) + "," + users;
  if (interface.empty()) {
    return configuration(
        "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>"
        "<AllowMulticast>false</AllowMulticast></General>"
        "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        "<Peers><Peer address=\"localhost\"/></Peers>"
        "<SPDPInterval>500 ms</SPDPInterval></Discovery>" +  // who comes is found within it: nobody else is heard
        writing);
  }
  const bool isAddress = interface.find_first_not_of("0123456789.") == std::string::npos;
  return configuration("<General><Interfaces><NetworkInterface " + std::string(isAddress ? "address" : "name") + "=\"" +
                       interface + "\"/></Interfaces></General>" + writing);
}

/// Of a topic of ROS 2, for readers and writers.
std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> settings(const Qos& qos) {
  std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> made(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(
      made.get(), qos.reliability == Reliability::kReliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
      0);
  dds_qset_history(made.get(), DDS_HISTORY_KEEP_LAST, qos.depth);
  dds_qset_durability(made.get(), qos.transientLocal ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_durability_service(made.get(), 0, DDS_HISTORY_KEEP_LAST, qos.depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  dds_data_representation_id_t plainCdr = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(made.get(), 1, &plainCdr);
#if HAPTICS_BATCHING_IS_A_POLICY
  dds_qset_writer_batching(made.get(), true);
#endif
  return made;
}

Entity orThrow(dds_entity_t handle, const std::string& what) {
  if (handle > 0) return Entity(handle);
  throw std::runtime_error(what + ": " + dds_strretcode(-handle));
}

Entity makeTopic(const Participant& participant, const dds_topic_descriptor_t& type, const TopicName& topic) {
  return orThrow(dds_create_topic(participant.get(), &type, topic.inDds.c_str(), nullptr, nullptr),
                 "topic " + topic.inDds);
}

}  // namespace

Result<Participant> Participant::join(std::uint32_t domain, const std::string& interface, const std::string& users) {
  const auto isPlain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' ||
           c == '_';
  };
  if (!std::ranges::all_of(interface, isPlain))
    return refused("--interface", "neither the name nor the IPv4 address of a network interface");
  const auto refusal = [](dds_return_t code) {
    return refused("--interface", std::string("DDS cannot be used so, as it says above: ") + dds_strretcode(-code));
  };
  const dds_entity_t made = dds_create_domain(domain, settings(interface, users).c_str());
  if (made < 0) return refusal(made);
  Entity domainEntity(made);
  const dds_entity_t participant = dds_create_participant(domain, nullptr, nullptr);
  if (participant < 0) return refusal(participant);
  return Participant(std::move(domainEntity), Entity(participant));
}

Entity makeWriter(const Participant& participant, const dds_topic_descriptor_t& type, const TopicName& topic,
                  const Qos& qos) {
  const Entity described = makeTopic(participant, type, topic);
  return orThrow(dds_create_writer(participant.get(), described.get(), settings(qos).get(), nullptr),
                 "topic " + topic.inDds);
}

Entity makeReader(const Participant& participant, const dds_topic_descriptor_t& type, const TopicName& topic,
                  const Qos& qos) {
  const Entity described = makeTopic(participant, type, topic);
  return orThrow(dds_create_reader(participant.get(), described.get(), settings(qos).get(), nullptr),
                 "topic " + topic.inDds);
}

bool allAreHeardBy(dds_entity_t reader, dds_entity_t writer) {
  using Key = std::array<std::uint8_t, 16>;
  const auto participants = [](dds_entity_t of, const auto& matched, const auto& dataOf) {
    constexpr std::size_t kMaxMatched = 64;
    dds_instance_handle_t handles[kMaxMatched];
    const dds_return_t count = matched(of, handles, kMaxMatched);
    std::set<Key> keys;
    for (std::size_t i = 0; i < std::min<std::size_t>(kMaxMatched, static_cast<std::size_t>(std::max(count, 0))); ++i) {
      dds_builtintopic_endpoint_t* const data = dataOf(of, handles[i]);
      if (data == nullptr) continue;
      Key key;
      std::copy_n(data->participant_key.v, key.size(), key.begin());
      keys.insert(key);
      dds_builtintopic_free_endpoint(data);
    }
    return keys;
  };
  const auto writing = participants(reader, dds_get_matched_publications, dds_get_matched_publication_data);
  const auto reading = participants(writer, dds_get_matched_subscriptions, dds_get_matched_subscription_data);
  return std::ranges::includes(reading, writing);
}

}  // namespace haptics::dds
