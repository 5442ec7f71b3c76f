#include "tests/stress/nats_cluster.h"

#include <algorithm>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <fstream>
#include <optional>
#include <stdexcept>

#include "graphics_client/audience/nats_connection.h"
#include "tests/stress/run_files.h"

namespace haptics::stress {
namespace {

constexpr double kClusterPatience_s = 30;
constexpr const char* kProgram = "/usr/sbin/nats-server";

std::vector<std::uint16_t> freePorts(std::size_t count) {
  asio::io_context context;
  std::vector<asio::ip::tcp::acceptor> held;
  std::vector<std::uint16_t> ports;
  for (std::size_t i = 0; i < count; ++i) {
    held.emplace_back(context, asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    ports.push_back(held.back().local_endpoint().port());
  }
  return ports;
}

/// Nothing: nobody leads just now.
std::optional<std::string> leaderOf(const std::string& urls, const std::string& stream) {
  const auto connection = NatsConnection::open({.url = urls, .clientName = "haptic_stress"});
  if (!connection) return std::nullopt;
  jsCtx* made = nullptr;
  if (natsConnection_JetStream(&made, (*connection)->handle(), nullptr) != NATS_OK) return std::nullopt;
  const nats::JetStream owner(made);
  jsStreamInfo* info = nullptr;
  if (js_GetStreamInfo(&info, made, stream.c_str(), nullptr, nullptr) != NATS_OK) return std::nullopt;
  std::optional<std::string> leader;
  if (info->Cluster != nullptr && info->Cluster->Leader != nullptr) leader = info->Cluster->Leader;
  jsStreamInfo_Destroy(info);
  return leader;
}

}  // namespace

NatsCluster::NatsCluster(const std::filesystem::path& out, int nodes) {
  if (!std::filesystem::exists(kProgram)) throw std::runtime_error(std::string(kProgram) + " is not installed");
  const auto count = static_cast<std::size_t>(nodes);
  const auto ports = freePorts(2 * count);
  std::string routes;
  for (std::size_t i = 0; i < count; ++i)
    routes += (i == 0 ? "\"nats://127.0.0.1:" : ", \"nats://127.0.0.1:") + std::to_string(ports[count + i]) + "\"";
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = "nats" + std::to_string(i + 1);
    const auto config = out / (name + ".conf"), store = out / name;
    std::filesystem::remove_all(store);
    std::ofstream file(config);
    file << "server_name: " << name << "\nlisten: \"127.0.0.1:" << ports[i] << "\"\njetstream { store_dir: \""
         << store.string() << "\", max_file_store: 8G }\n";
    if (count > 1) {
      file << "cluster { name: audience, listen: \"127.0.0.1:" << ports[count + i] << "\", routes: [" << routes
           << "] }\n";
    }
    file.close();
    nodes_.push_back({name, ports[i], Child({kProgram, "-c", config.string()}, out / (name + ".log"), [] {})});
  }
  waitUntil(kClusterPatience_s, "the NATS servers are ready: see their logs in " + out.string(), [&] {
    return std::ranges::all_of(nodes_, [&](const Node& node) {
      std::ifstream log(out / (node.name + ".log"));
      const std::string text((std::istreambuf_iterator<char>(log)), {});
      const bool hasLeader = count == 1 || text.find("metadata leader") != std::string::npos;
      return text.find("Server is ready") != std::string::npos && hasLeader;
    });
  });
}

std::string NatsCluster::urls() const {
  std::string urls;
  for (const Node& node : nodes_) urls += (urls.empty() ? "" : ",") + ("nats://127.0.0.1:" + std::to_string(node.port));
  return urls;
}

std::string NatsCluster::killLeaderOf(const std::string& stream) {
  std::optional<std::string> leader;
  waitUntil(kClusterPatience_s, "somebody leads " + stream,
            [&] { return (leader = leaderOf(urls(), stream)).has_value(); });
  const auto node = std::ranges::find(nodes_, *leader, &Node::name);
  if (node == nodes_.end()) throw std::runtime_error(stream + " is led by " + *leader + ", which is not ours");
  node->process.kill();
  return *leader;
}

}  // namespace haptics::stress
