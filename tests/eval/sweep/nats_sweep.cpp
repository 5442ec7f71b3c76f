#include "tests/eval/sweep/nats_sweep.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>

#include "common/hash/content_hash.h"
#include "common/nats/nats_credentials.h"
#include "common/nats/nats_handles.h"
#include "common/nats/nats_socket.h"
#include "common/text/printable.h"
#include "tests/eval/or_throw.h"
#include "tests/eval/sweep/sweep_progress.h"
#include "tests/eval/table1/interruption.h"

namespace haptics::eval {
namespace {

// Parts are sent to haptic_eval.parts.BUILD.SWEEP, what they came to to haptic_eval.results.SWEEP; both name build, sweep and
// part, and their header Seal shows that a program of the build has written them for this subject. What has none, or another,
// is thrown away unread. A worker that has nothing to do asks haptic_eval.hello whether it may stay.
constexpr const char* kPartsStream = "HAPTIC_EVAL_PARTS";
constexpr const char* kParts = "haptic_eval.parts.";
constexpr const char* kResultsStream = "HAPTIC_EVAL_RESULTS";
constexpr const char* kResults = "haptic_eval.results.";
constexpr const char* kHello = "haptic_eval.hello";
constexpr const char* kSeal = "Seal";
constexpr std::int64_t kHeaders_bytes = 256;  // with the seal
constexpr std::size_t kShortHash = 16;        // digits

using std::chrono::milliseconds;
constexpr milliseconds kPoll{500};
/// A worker says so often that it is at work; after the other a part is given to another one.
constexpr milliseconds kAlive{1000}, kLeft{5000};
constexpr std::uint64_t kMaxTries = 3;
constexpr int kMakingTries = 50;
/// A result that is not stored is sent again: twice as late each time, up to the longest.
constexpr double kFirstPause_s = 0.5, kLongestPause_s = 8;
constexpr std::int64_t kStoredWithin_ms = 1000;
/// An interruption ends the program by then, whatever NATS does.
constexpr milliseconds kEndWithin{1500};
constexpr std::int64_t kWriteWithin_ms = 2000;
constexpr int kRefusedBriefly = 3;  // lines about results of strangers
constexpr std::int64_t kBetweenTries_ms = 20;
/// Without a result or a worker for so long, the user reads how to start one.
constexpr std::chrono::seconds kNobody{5};
constexpr std::int64_t kNanoseconds = 1'000'000;                                   // in a millisecond
constexpr std::int64_t kKept = std::int64_t{7} * 24 * 3600 * 1000 * kNanoseconds;  // results of a sweep nobody ends

struct Connected {
  nats::Connection connection;
  nats::JetStream stream;
};

/// Throws std::runtime_error with what was wanted and what NATS says.
void must(natsStatus status, const std::string& what) {
  if (status != NATS_OK) throw std::runtime_error("NATS: " + what + ": " + natsErrorText(status));
}

[[nodiscard]] std::string_view dataOf(const natsMsg& message) noexcept {
  return {natsMsg_GetData(&message), static_cast<std::size_t>(natsMsg_GetDataLength(&message))};
}

void ensureStream(jsCtx& stream, const char* name, const char* subject, jsRetentionPolicy retention) {
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = name;
  config.Subjects = &subject;
  config.SubjectsLen = 1;
  config.Retention = retention;
  config.MaxAge = kKept;
  jsErrCode error{};
  // While another makes the same stream the server says that their subjects overlap.
  for (int tries = 0; tries < kMakingTries; ++tries) {
    if (js_AddStream(nullptr, &stream, &config, nullptr, &error) == NATS_OK || error == JSStreamNameExistErr) return;
    if (error != JSStreamSubjectOverlapErr) break;
    nats_Sleep(kBetweenTries_ms);
  }
  must(NATS_ERR, std::string("the stream ") + name + " cannot be made; is JetStream on, and not full?");
}

[[nodiscard]] Connected connect(const NatsServer& server) {
  std::optional<NatsCredentials> credentials;
  if (!server.credentials.empty()) credentials = orThrow(readNatsCredentials(server.credentials));
  natsOptions* made = nullptr;
  must(natsOptions_Create(&made), "options");
  const nats::Options options(made);
  must(setNatsServers(*options, server.url, credentials), "--nats " + server.url);
  must(natsOptions_SetMaxReconnect(options.get(), -1), "options");
  must(natsOptions_SetWriteDeadline(options.get(), kWriteWithin_ms), "options");
  natsConnection* connection = nullptr;
  NatsSocket socket;
  must(connectToNats(connection, *options, server.url, {}, socket), "no connection to " + server.url);
  Connected connected{nats::Connection(connection), nullptr};
  jsCtx* stream = nullptr;
  must(natsConnection_JetStream(&stream, connection, nullptr), "JetStream");
  connected.stream.reset(stream);
  ensureStream(*stream, kPartsStream, "haptic_eval.parts.>", js_WorkQueuePolicy);
  ensureStream(*stream, kResultsStream, "haptic_eval.results.>", js_LimitsPolicy);
  return connected;
}

[[nodiscard]] std::string dumped(const Record& record) {
  return record.dump(-1, ' ', false, Record::error_handler_t::replace);
}

[[nodiscard]] std::string shortOf(const std::string& hash) { return hash.substr(0, kShortHash); }

[[nodiscard]] std::string thisMachine() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "somewhere";
}

/// Publishes the text with its seal; waits until it is stored.
[[nodiscard]] natsStatus publishSealed(jsCtx& stream, const ProgramSeal& seal, const std::string& subject,
                                       const std::string& text) {
  natsMsg* made = nullptr;
  natsStatus status = natsMsg_Create(&made, subject.c_str(), nullptr, text.data(), static_cast<int>(text.size()));
  const nats::Message message(made);
  if (status == NATS_OK) status = natsMsgHeader_Set(made, kSeal, seal.of(subject, text).c_str());
  jsPubOptions options;
  jsPubOptions_Init(&options);
  options.MaxWait = kStoredWithin_ms;
  return status == NATS_OK ? js_PublishMsg(nullptr, &stream, made, &options, nullptr) : status;
}

/// What a program of this build has published for this subject; discarded: anything else, and what is no record.
[[nodiscard]] Record sealedRecord(natsMsg& message, const ProgramSeal& seal, const std::string& subject) {
  const char* given = nullptr;
  if (natsMsgHeader_Get(&message, kSeal, &given) != NATS_OK || given == nullptr ||
      seal.of(subject, dataOf(message)) != given) {
    return Record(Record::value_t::discarded);
  }
  return Record::parse(dataOf(message), nullptr, false);
}

/// Ends the program where it does not end by itself soon after an interruption: it is at work, or NATS does not answer. What
/// was not done is done by others, or with the next start.
class LastResort {
 public:
  explicit LastResort(const Interruption& interruption)
      : thread_([&interruption](const std::stop_token& stop) {
          auto since = std::chrono::steady_clock::now();
          while (!stop.stop_requested()) {
            std::this_thread::sleep_for(milliseconds(20));
            const auto now = std::chrono::steady_clock::now();
            if (!interruption.came()) since = now;
            if (now - since < kEndWithin) continue;
            std::fputs("interrupted within a part, or while NATS does not answer\n", stderr);
            _exit(1);
          }
        }) {}

 private:
  std::jthread thread_;
};

void purge(jsCtx& stream, const char* name, const std::string& subject) {
  jsOptions options;
  jsOptions_Init(&options);
  options.Stream.Purge.Subject = subject.c_str();
  must(js_PurgeStream(&stream, name, &options, nullptr), "what is left of the sweep cannot be taken away");
}

/// The side that gives out parts.
class Giver {
 public:
  Giver(Sweep& sweep, const SweepArguments& arguments, const NatsServer& server)
      : sweep_(sweep),
        arguments_(arguments),
        url_(server.url),
        build_(buildHash()),
        id_(shortOf(idOf(arguments, build_))),
        nats_(connect(server)),
        results_(sweep.size()) {}

  [[nodiscard]] std::vector<Record> results() {
    const Interruption interruption;
    const LastResort lastResort(interruption);
    takeEarlierResults(interruption);
    if (left_ > 0) giveParts();
    natsSubscription* hellos = nullptr;
    must(natsConnection_SubscribeSync(&hellos, nats_.connection.get(), kHello), kHello);
    hellos_.reset(hellos);
    SweepProgress progress(results_.size(), results_.size() - left_);
    auto lastSign = std::chrono::steady_clock::now();
    while (left_ > 0) {
      if (interruption.came()) {
        purge(*nats_.stream, kPartsStream, partsSubject());
        throw std::runtime_error("interrupted; the same command goes on with the parts that are left");
      }
      if (answerHellos(*hellos) || takeResult(kPoll)) lastSign = std::chrono::steady_clock::now();
      progress.show(results_.size() - left_);
      if (std::chrono::steady_clock::now() - lastSign > kNobody && !hasSaidHow_) {
        hasSaidHow_ = true;
        std::fprintf(stderr, "no worker of this build has been heard of; start some:\n  haptic_eval worker --nats %s\n",
                     url_.c_str());
      }
    }
    // Its parts are all done. They are not purged: nats-server 2.9 then skips those of other sweeps, too.
    purge(*nats_.stream, kResultsStream, resultsSubject());
    std::vector<Record> results;
    for (auto& result : results_) results.push_back(std::move(*result));
    return results;
  }

 private:
  [[nodiscard]] static std::string idOf(const SweepArguments& arguments, const std::string& build) {
    Hasher hasher;
    hasher.add(build);
    for (const std::string& argument : arguments) hasher.add(argument);
    return hasher.finish().hex();
  }
  [[nodiscard]] std::string partsSubject() const { return kParts + shortOf(build_) + '.' + id_; }
  [[nodiscard]] std::string resultsSubject() const { return kResults + id_; }

  void takeEarlierResults(const Interruption& interruption) {
    left_ = results_.size();
    jsSubOptions options;
    jsSubOptions_Init(&options);
    options.Stream = kResultsStream;
    options.Ordered = true;
    natsSubscription* subscription = nullptr;
    must(js_SubscribeSync(&subscription, nats_.stream.get(), resultsSubject().c_str(), nullptr, &options, nullptr),
         "results");
    subscription_.reset(subscription);
    while (!interruption.came() && takeResult(kPoll)) {
    }
    if (left_ < results_.size())
      std::fprintf(stderr, "%zu parts are done already: an earlier run of the same sweep was interrupted\n",
                   results_.size() - left_);
  }

  void giveParts() {
    purge(*nats_.stream, kPartsStream, partsSubject());
    for (std::size_t part = 0; part < results_.size(); ++part) {
      if (results_[part]) continue;
      const std::string text = dumped({{"sweep", id_}, {"build", build_}, {"arguments", arguments_}, {"part", part}});
      must(publishSealed(*nats_.stream, seal_, partsSubject(), text),
           "part " + std::to_string(part) + " was not taken");
    }
  }

  /// @return Whether a result came.
  bool takeResult(milliseconds within) {
    natsMsg* message = nullptr;
    if (natsSubscription_NextMsg(&message, subscription_.get(), within.count()) != NATS_OK) return false;
    const nats::Message taken(message);
    const Record result = sealedRecord(*message, seal_, resultsSubject());
    if (!result.is_object()) {
      if (++strange_ <= kRefusedBriefly)
        std::fputs("a result that no worker of this build has sent is not taken\n", stderr);
      return true;
    }
    const auto part = result["part"].get<std::size_t>();
    if (part >= results_.size() || results_[part]) return true;
    if (!result.contains("result")) {
      purge(*nats_.stream, kPartsStream, partsSubject());
      purge(*nats_.stream, kResultsStream, resultsSubject());
      throw std::runtime_error("part " + std::to_string(part) + " of " + std::to_string(results_.size()) +
                               " was tried " + std::to_string(kMaxTries) +
                               " times: " + result.value("failed", "no reason was given"));
    }
    results_[part] = result["result"];
    --left_;
    return true;
  }

  /// @return Whether a worker of this build asked.
  bool answerHellos(natsSubscription& hellos) {
    bool any = false;
    natsMsg* message = nullptr;
    while (natsSubscription_NextMsg(&message, &hellos, 0) == NATS_OK) {
      const nats::Message hello(message);
      const bool isOurs = dataOf(*message).substr(0, build_.size()) == build_;
      any = any || isOurs;
      if (natsMsg_GetReply(message) == nullptr) continue;
      if (!isOurs)
        std::fprintf(stderr, "a worker of another build is refused: %.*s\n", natsMsg_GetDataLength(message),
                     natsMsg_GetData(message));
      const std::string answer =
          isOurs ? ""
                 : arguments_.front() + " is run by build " + shortOf(build_) + "; use the same program everywhere";
      static_cast<void>(
          natsConnection_PublishString(nats_.connection.get(), natsMsg_GetReply(message), answer.c_str()));
    }
    return any;
  }

  Sweep& sweep_;
  const SweepArguments& arguments_;
  std::string url_, build_, id_;
  ProgramSeal seal_;
  int strange_ = 0;
  nats::Subscription subscription_,
      hellos_;  // outlive the connection: libnats 3.4 crashes on a message for one that is gone
  Connected nats_;
  std::vector<std::optional<Record>> results_;
  std::size_t left_ = 0;
  bool hasSaidHow_ = false;
};

/// Says every second that the part is being worked on.
class KeptAlive {
 public:
  explicit KeptAlive(natsMsg& message)
      : thread_([&message](const std::stop_token& stop) {
          auto next = std::chrono::steady_clock::now() + kAlive;
          while (!stop.stop_requested()) {
            std::this_thread::sleep_for(milliseconds(20));
            if (std::chrono::steady_clock::now() < next) continue;
            static_cast<void>(natsMsg_InProgress(&message, nullptr));
            next += kAlive;
          }
        }) {}

 private:
  std::jthread thread_;
};

class Worker {
 public:
  Worker(const NatsServer& server, const SweepMaker& makeSweep)
      : makeSweep_(makeSweep), build_(buildHash()), nats_(connect(server)) {
    jsSubOptions options;
    jsSubOptions_Init(&options);
    options.Stream = kPartsStream;
    options.Config.AckPolicy = js_AckExplicit;
    options.Config.AckWait = kLeft.count() * kNanoseconds;
    natsSubscription* subscription = nullptr;
    must(js_PullSubscribe(&subscription, nats_.stream.get(), (kParts + shortOf(build_) + ".*").c_str(),
                          ("workers-" + shortOf(build_)).c_str(), nullptr, &options, nullptr),
         "parts");
    subscription_.reset(subscription);
  }

  void work() {
    const Interruption interruption;
    const LastResort lastResort(interruption);
    std::printf("worker of build %s: waiting for parts\n", shortOf(build_).c_str());
    std::fflush(stdout);
    while (!interruption.came()) {
      natsMsgList list{};
      const natsStatus status = natsSubscription_Fetch(&list, subscription_.get(), 1, kPoll.count(), nullptr);
      if (status == NATS_OK && list.Count == 1) {
        runPart(*list.Msgs[0], interruption);
        natsMsgList_Destroy(&list);
      } else if (status == NATS_TIMEOUT) {
        askWhetherToStay();
      } else {
        interruption.sleep(1);  // until NATS is back
      }
    }
    std::printf("%zu parts done\n", done_);
  }

 private:
  void runPart(natsMsg& message, const Interruption& interruption) {
    const Record job = sealedRecord(message, seal_, natsMsg_GetSubject(&message));
    if (!job.is_object()) {
      std::fprintf(stderr, "what came is no part that this build has given out; it is thrown away\n");
      static_cast<void>(natsMsg_Term(&message, nullptr));
      return;
    }
    const KeptAlive alive(message);
    const std::uint64_t tries = deliveriesOf(message);
    Record result{{"part", job["part"]}, {"sweep", job["sweep"]}, {"build", build_}};
    if (tries > kMaxTries) {
      result["failed"] = "each time the worker ended without a word";
    } else {
      try {
        result["result"] = sweepOf(job["arguments"]).run(job["part"].get<std::size_t>());
        ++done_;
      } catch (const std::exception& error) {
        std::fprintf(stderr, "part %zu: %s\n", job["part"].get<std::size_t>(), printable(error.what()).c_str());
        if (tries >= kMaxTries) result["failed"] = thisMachine() + ": " + error.what();
      }
    }
    if (!result.contains("result") && !result.contains("failed")) {
      static_cast<void>(natsMsg_NakWithDelay(&message, kAlive.count(), nullptr));
      return;
    }
    std::string text = dumped(result);
    const std::int64_t most = natsConnection_GetMaxPayload(nats_.connection.get()) - kHeaders_bytes;
    if (static_cast<std::int64_t>(text.size()) > most) {
      result.erase("result");
      result["failed"] = "its result has " + std::to_string(text.size()) + " bytes, NATS takes " +
                         std::to_string(most) + "; raise max_payload, or use --shard";
      text = dumped(result);
    }
    if (send(kResults + job["sweep"].get<std::string>(), text, interruption))
      static_cast<void>(natsMsg_Ack(&message, nullptr));
  }

  [[nodiscard]] static std::uint64_t deliveriesOf(natsMsg& message) {
    jsMsgMetaData* data = nullptr;
    must(natsMsg_GetMetaData(&data, &message), "a part without its number of tries");
    const std::uint64_t deliveries = data->NumDelivered;
    jsMsgMetaData_Destroy(data);
    return deliveries;
  }

  [[nodiscard]] Sweep& sweepOf(const SweepArguments& arguments) {
    if (!sweep_ || arguments != arguments_) {
      sweep_ = makeSweep_(arguments);
      arguments_ = arguments;
    }
    return *sweep_;
  }

  /// Until it is stored. False: interrupted.
  [[nodiscard]] bool send(const std::string& subject, const std::string& text, const Interruption& interruption) {
    double pause_s = kFirstPause_s;
    std::string said;
    while (true) {
      const natsStatus status = publishSealed(*nats_.stream, seal_, subject, text);
      if (status == NATS_OK) return true;
      const std::string why = natsErrorText(status);
      if (why != said) std::fprintf(stderr, "a result was not stored (%s); trying again\n", printable(why).c_str());
      said = why;
      interruption.sleep(pause_s);
      if (interruption.came()) return false;
      pause_s = std::min(kLongestPause_s, 2 * pause_s);
    }
  }

  void askWhetherToStay() {
    natsMsg* message = nullptr;
    const std::string hello = build_ + ' ' + thisMachine();
    if (natsConnection_RequestString(&message, nats_.connection.get(), kHello, hello.c_str(), kPoll.count()) != NATS_OK)
      return;  // nobody gives out parts now
    const nats::Message answer(message);
    if (natsMsg_GetDataLength(message) > 0)
      throw std::runtime_error("refused, for this is build " + shortOf(build_) + ": " + std::string(dataOf(*message)));
  }

  const SweepMaker& makeSweep_;
  std::string build_;
  ProgramSeal seal_;
  nats::Subscription subscription_;  // outlives the connection, as the giver's
  Connected nats_;
  SweepArguments arguments_;
  std::unique_ptr<Sweep> sweep_;
  std::size_t done_ = 0;
};

}  // namespace

bool runSweepOverNats(Sweep& sweep, const SweepArguments& arguments, const NatsServer& server) {
  const std::vector<Record> results = Giver(sweep, arguments, server).results();
  for (std::size_t part = 0; part < results.size(); ++part) sweep.print(part, results[part]);
  return sweep.finish(results);
}

void workOnSweeps(const NatsServer& server, const SweepMaker& makeSweep) { Worker(server, makeSweep).work(); }

}  // namespace haptics::eval
