// Runs a method from a shared library for haptic_eval: reads messages from standard input, writes answers to what was its
// standard output.

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include "tests/eval/adapters/protocol.h"

namespace haptics::eval::adapter {
namespace {

constexpr int kExitWrong = 2;

[[noreturn]] void giveUp(const std::string& why) {
  std::fprintf(stderr, "method_host: %s\n", why.c_str());
  std::_Exit(kExitWrong);
}

/// Bytes that end where memory ends: who writes beyond is stopped there.
class GuardedBytes {
 public:
  GuardedBytes() = default;
  explicit GuardedBytes(std::size_t size) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    whole_ = (size + page - 1) / page * page + page;
    void* const mapped = mmap(nullptr, whole_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) giveUp("no memory for " + std::to_string(size) + " bytes");
    begin_ = static_cast<char*>(mapped);
    data_ = begin_ + (whole_ - page) - (size + 7) / 8 * 8;
    if (mprotect(begin_ + (whole_ - page), page, PROT_NONE) != 0) giveUp("memory cannot be guarded");
  }
  GuardedBytes(GuardedBytes&& other) noexcept { swap(other); }
  GuardedBytes& operator=(GuardedBytes&& other) noexcept {
    swap(other);
    return *this;
  }
  ~GuardedBytes() {
    if (begin_ != nullptr) munmap(begin_, whole_);
  }

  [[nodiscard]] char* data() const { return data_; }
  void makeReadOnly() const {
    if (mprotect(begin_, whole_ - static_cast<std::size_t>(sysconf(_SC_PAGESIZE)), PROT_READ) != 0)
      giveUp("memory cannot be guarded");
  }

 private:
  void swap(GuardedBytes& other) noexcept {
    std::swap(begin_, other.begin_);
    std::swap(data_, other.data_);
    std::swap(whole_, other.whole_);
  }

  char* begin_ = nullptr;
  char* data_ = nullptr;
  std::size_t whole_ = 0;
};

/// Ends the process in order when there is no more.
void readAll(char* to, std::size_t count) {
  while (count > 0) {
    const ssize_t got = read(STDIN_FILENO, to, count);
    if (got <= 0) std::_Exit(0);
    to += got;
    count -= static_cast<std::size_t>(got);
  }
}

class Host {
 public:
  Host(const haptics_method_functions& method, int output) : method_(method), output_(output) {}

  [[noreturn]] void run() {
    for (;;) {
      Head head;
      readAll(reinterpret_cast<char*>(&head), sizeof head);
      const GuardedBytes bytes(head.bytes);
      readAll(bytes.data(), head.bytes);
      take(head, bytes);
    }
  }

 private:
  void take(const Head& head, const GuardedBytes& bytes) {
    switch (head.kind) {
      case Kind::kHello:
        return hello();
      case Kind::kLoad:
        return load(head.bytes, bytes);
      case Kind::kPlace: {
        std::array<double, 3> hip;
        std::memcpy(hip.data(), bytes.data(), sizeof hip);
        method_.place(hip.data());
        return answer(Kind::kPlace, nullptr, 0);
      }
      case Kind::kTick:
        return tick(bytes);
      case Kind::kRefusal:
        break;
    }
    giveUp("a message of unknown kind");
  }

  void hello() {
    const Hello own{method_.abi, method_.abilities};
    std::string said(reinterpret_cast<const char*>(&own), sizeof own);
    said += std::string(method_.name) + '\n' + method_.version;
    answer(Kind::kHello, said.data(), said.size());
  }

  void load(std::size_t size, const GuardedBytes& bytes) {
    GuardedBytes kept(size);
    std::memcpy(kept.data(), bytes.data(), size);
    LoadHead head;
    std::memcpy(&head, kept.data(), sizeof head);
    const char* const heads = kept.data() + sizeof head;
    const char* arrays = heads + head.bodies * sizeof(BodyHead);
    std::vector<haptics_body> bodies;
    for (std::uint32_t i = 0; i < head.bodies; ++i) {
      BodyHead body;
      std::memcpy(&body, heads + i * sizeof body, sizeof body);
      const auto* const vertices = reinterpret_cast<const float*>(arrays);
      arrays += std::size_t{3} * body.vertices * sizeof(float);
      const auto* const triangles = reinterpret_cast<const std::uint32_t*>(arrays);
      arrays += std::size_t{3} * body.triangles * sizeof(std::uint32_t);
      bodies.push_back({body.vertices, body.triangles, body.isClosed, 0, body.stiffness_N_per_m, body.staticFriction,
                        body.dynamicFriction, body.crease_rad, body.pose, vertices, triangles});
    }
    kept.makeReadOnly();
    const haptics_scene scene{head.bodies, 0, {head.hip_m[0], head.hip_m[1], head.hip_m[2]}, bodies.data()};
    const char* const why = method_.load(&scene);
    scene_ = std::move(kept);  // what was read before is given back only now
    bodies_ = std::move(bodies);
    if (why == nullptr) return answer(Kind::kLoad, nullptr, 0);
    answer(Kind::kRefusal, why, strnlen(why, kMaxAnswer_bytes));
  }

  void tick(const GuardedBytes& bytes) {
    std::array<double, 3> hip;
    std::memcpy(hip.data(), bytes.data(), sizeof hip);
    auto& felt = *reinterpret_cast<haptics_answer*>(felt_.data());
    felt = {};
    const auto* const poses = reinterpret_cast<const haptics_pose*>(bytes.data() + sizeof hip);
    const auto begin = std::chrono::steady_clock::now();
    method_.tick(poses, hip.data(), &felt);
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    Answer said{};
    std::memcpy(said.force_N, felt.force_N, sizeof said.force_N);
    std::memcpy(said.ihip_m, felt.ihip_m, sizeof said.ihip_m);
    std::memcpy(said.torque_Nm, felt.torque_Nm, sizeof said.torque_Nm);
    said.duration_ns = taken.count();
    said.flags = felt.flags;
    said.triangles = felt.triangles;
    answer(Kind::kTick, &said, sizeof said);
  }

  void answer(Kind kind, const void* data, std::size_t size) {
    const Head head{kind, static_cast<std::uint32_t>(size)};
    said_.assign(reinterpret_cast<const char*>(&head), sizeof head);
    said_.append(static_cast<const char*>(data), size);
    std::size_t done = 0;
    while (done < said_.size()) {
      const ssize_t count = write(output_, said_.data() + done, said_.size() - done);
      if (count <= 0) std::_Exit(0);
      done += static_cast<std::size_t>(count);
    }
  }

  const haptics_method_functions& method_;
  int output_;
  GuardedBytes scene_;
  std::vector<haptics_body> bodies_;
  GuardedBytes felt_{sizeof(haptics_answer)};
  std::string said_;
};

const haptics_method_functions& methodOf(const char* file) {
  void* const library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) giveUp(dlerror());
  const auto get = reinterpret_cast<decltype(&haptics_method)>(dlsym(library, "haptics_method"));
  if (get == nullptr) giveUp(std::string(file) + ": exports no haptics_method()");
  const haptics_method_functions* const method = get();
  if (method == nullptr) giveUp(std::string(file) + ": haptics_method() returns nothing");
  if (method->abi != HAPTICS_METHOD_ABI)
    giveUp(std::string(file) + ": is of version " + std::to_string(method->abi) + "; version " +
           std::to_string(HAPTICS_METHOD_ABI) + " is right");
  if (method->name == nullptr || method->version == nullptr || method->load == nullptr || method->place == nullptr ||
      method->tick == nullptr)
    giveUp(std::string(file) + ": a function, the name or the version is missing");
  return *method;
}

}  // namespace
}  // namespace haptics::eval::adapter

int main(int argc, char** argv) {
  using namespace haptics::eval::adapter;
  if (argc != 2) giveUp("give the file of a shared library; haptic_eval starts this program");
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int output = dup(STDOUT_FILENO);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  try {
    Host(methodOf(argv[1]), output).run();
  } catch (const std::exception& error) {
    giveUp(std::string("the method threw: ") + error.what());
  }
}
