#include "haptic_server/net/admission.h"

#include <algorithm>
#include <cstring>

namespace haptics {

Admission::Admission(const std::optional<ServerCredentials>& credentials) {
  if (credentials) tokens_.emplace(*credentials);
}

Result<Role> Admission::admit(SessionId session, const std::string& token, std::span<const Client> others) const {
  const ContentHash hash = hashOfToken(token);
  std::optional<Role> role = Role::kEdit;
  if (tokens_ && token.empty()) return refused("hello.token", "is missing; connect with --credentials FILE");
  if (tokens_) role = tokens_->roleOf(hash);
  if (!role) return refused("hello.token", "is not one that this server knows, or was withdrawn");
  if (std::ranges::any_of(others, [&](const Client& o) { return o.session == session && o.token != hash; })) {
    return refused("hello.session", "is that of a client with another token; choose one at random");
  }
  const auto count = [&](const auto& counts) {
    return std::ranges::count_if(others, [&](const Client& o) { return o.session != session && counts(o); });
  };
  const auto reached = [](std::ptrdiff_t number, std::size_t most) {
    return number >= static_cast<std::ptrdiff_t>(most);
  };
  if (reached(count([](const Client&) { return true; }), kMaxClients)) {
    return refused("", "the server has its " + std::to_string(kMaxClients) + " clients");
  }
  if (role == Role::kView && reached(count([](const Client& o) { return o.role == Role::kView; }), kMaxViewers)) {
    return refused("", "the server has its " + std::to_string(kMaxViewers) + " viewers; the other places are editors'");
  }
  if (tokens_ && reached(count([&](const Client& o) { return o.token == hash; }), kMaxClientsOfToken)) {
    return refused("hello.token",
                   "is that of " + std::to_string(kMaxClientsOfToken) + " clients already; connect with another token");
  }
  return *role;
}

SessionId Admission::editSession(const Client& client) const {
  if (!tokens_) return client.session;
  const ContentHash bound = Hasher().add(client.token).add(client.session).finish();
  SessionId session = 0;
  std::memcpy(&session, bound.bytes.data(), sizeof session);
  return session == kServerSession ? client.session : session;
}

Result<bool> Admission::refresh(bool anyway) { return tokens_ ? tokens_->refresh(anyway) : Result<bool>(false); }

Result<void> Admission::check(const Client& client) const {
  const auto role = tokens_ ? tokens_->roleOf(client.token) : client.role;
  if (!role) return refused("hello.token", "was withdrawn");
  if (*role != client.role) return refused("hello.token", "has another role now; connect again");
  return {};
}

}  // namespace haptics
