#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "common/error/error.h"

// What the bridge needs of Cyclone DDS, with ROS 2's conventions.
namespace haptics::dds {

/// The topic's description that idlc has made for a message type; for those in message_types.h.
template <class Message>
[[nodiscard]] const dds_topic_descriptor_t& descriptorOf();

enum class Reliability { kReliable, kBestEffort };

struct Qos {
  Reliability reliability = Reliability::kReliable;
  /// Samples that a reliable writer keeps for readers that have lost some, and that wait in a reader. A writer with fewer
  /// loses some to a slow reader; none ever waits for one.
  int depth = 10;
  bool transientLocal = false;  ///< Who comes late gets the last one.
};

/// Deletes a DDS entity with all that it has made.
class Entity {
 public:
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() {
    if (handle_ > 0) dds_delete(handle_);
  }
  [[nodiscard]] dds_entity_t get() const noexcept { return handle_; }

 private:
  dds_entity_t handle_;
};

/// A domain and this program's participant in it.
class Participant {
 public:
  static constexpr std::uint32_t kMaxDomain = 232;  ///< Ports of higher ones are beyond 65,535.

  /// @param interface  Name or address of a network interface. Empty: only programs of this machine are spoken to, by
  ///                   127.0.0.1 without multicast, which a loopback interface usually does not have.
  /// @param users  Cyclone DDS's settings in place of interface and discovery, as its variable CYCLONEDDS_URI has them; empty:
  ///               none.
  /// Refused: there is no such interface, or it cannot be used.
  [[nodiscard]] static Result<Participant> join(std::uint32_t domain, const std::string& interface,
                                                const std::string& users);

  [[nodiscard]] dds_entity_t get() const noexcept { return participant_.get(); }

 private:
  Participant(Entity domain, Entity participant) : domain_(std::move(domain)), participant_(std::move(participant)) {}

  Entity domain_, participant_;  // the participant goes first
};

/// What ROS 2 calls a topic or a service, and how DDS has it.
struct TopicName {
  /// "/haptics/pose" is "rt/haptics/pose".
  TopicName(const std::string& topic) : inDds("rt" + topic) {}
  /// "/haptics/edit" has "rq/haptics/editRequest" and "rr/haptics/editReply".
  [[nodiscard]] static TopicName requestsTo(const std::string& service) { return {"rq", service, "Request"}; }
  [[nodiscard]] static TopicName repliesOf(const std::string& service) { return {"rr", service, "Reply"}; }

  std::string inDds;

 private:
  TopicName(const char* kind, const std::string& name, const char* ending) : inDds(kind + name + ending) {}
};

/// @throws std::runtime_error  what DDS says.
[[nodiscard]] Entity makeWriter(const Participant& participant, const dds_topic_descriptor_t& type,
                                const TopicName& topic, const Qos& qos);
[[nodiscard]] Entity makeReader(const Participant& participant, const dds_topic_descriptor_t& type,
                                const TopicName& topic, const Qos& qos);

/// Each participant that is known to write to the reader is known to read from the writer.
[[nodiscard]] bool allAreHeardBy(dds_entity_t reader, dds_entity_t writer);

template <class Message>
class Writer {
 public:
  Writer(const Participant& participant, const TopicName& topic, const Qos& qos)
      : entity_(makeWriter(participant, descriptorOf<Message>(), topic, qos)) {}

  /// Never waits. It is on its way when its packet is full, or after flush(). false: it was not written.
  bool write(const Message& message) { return dds_write(entity_.get(), &message) == DDS_RETCODE_OK; }
  /// Of a writer that keeps nothing for who comes late. Fast DDS goes through the numbers of all that was ever written when it finds
  /// a writer, 0.7 us each: what nobody reads gets none.
  bool writeToReaders(const Message& message) { return status().current_count == 0 || write(message); }
  void flush() { dds_write_flush(entity_.get()); }
  /// Readers that were matched since the writer was made, also those that are gone.
  [[nodiscard]] std::uint32_t readersSoFar() const { return status().total_count; }
  [[nodiscard]] dds_entity_t get() const noexcept { return entity_.get(); }

 private:
  Entity entity_;

  [[nodiscard]] dds_publication_matched_status_t status() const {
    dds_publication_matched_status_t status = {};
    dds_get_publication_matched_status(entity_.get(), &status);
    return status;
  }
};

template <class Message>
class Reader {
 public:
  Reader(const Participant& participant, const TopicName& topic, const Qos& qos)
      : entity_(makeReader(participant, descriptorOf<Message>(), topic, qos)) {}

  /// Gives each message that has come to `take`, which may not keep it.
  template <class Take>
  void takeAll(const Take& take) {
    constexpr std::size_t kAtOnce = 32;
    void* samples[kAtOnce] = {};
    dds_sample_info_t info[kAtOnce];
    while (true) {
      const dds_return_t count = dds_take(entity_.get(), samples, info, kAtOnce, kAtOnce);
      if (count <= 0) return;
      for (dds_return_t i = 0; i < count; ++i) {
        if (info[i].valid_data) take(*static_cast<const Message*>(samples[i]));
      }
      dds_return_loan(entity_.get(), samples, count);
    }
  }
  [[nodiscard]] dds_entity_t get() const noexcept { return entity_.get(); }

 private:
  Entity entity_;
};

/// Gives each message that comes to a function, on a thread of its own.
template <class Message>
class Subscription {
 public:
  using Take = std::function<void(const Message&)>;

  /// @param between  Messages are taken no more often; those that the reader has no room for are lost meanwhile.
  Subscription(const Participant& participant, const TopicName& topic, const Qos& qos, Take take,
               std::chrono::nanoseconds between = {})
      : take_(std::move(take)),
        between_(between),
        reader_(participant, topic, qos),
        waitset_(dds_create_waitset(participant.get())),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}

  [[nodiscard]] dds_entity_t get() const noexcept { return reader_.get(); }

 private:
  static constexpr dds_duration_t kLook = DDS_MSECS(100);

  const Take take_;
  const std::chrono::nanoseconds between_;
  Reader<Message> reader_;
  Entity waitset_;
  std::jthread thread_;  // ends first

  void run(const std::stop_token& stop) {
    const Entity some(dds_create_readcondition(reader_.get(), DDS_ANY_STATE));
    dds_waitset_attach(waitset_.get(), some.get(), 0);
    while (!stop.stop_requested()) {
      if (dds_waitset_wait(waitset_.get(), nullptr, 0, kLook) < 0)
        std::this_thread::sleep_for(std::chrono::nanoseconds(kLook));
      reader_.takeAll(take_);
      std::this_thread::sleep_for(between_);
    }
    dds_waitset_detach(waitset_.get(), some.get());
  }
};

}  // namespace haptics::dds
