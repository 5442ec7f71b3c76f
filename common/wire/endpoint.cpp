#include "common/wire/endpoint.h"

#include <asio/ip/address.hpp>
#include <charconv>

namespace haptics {
namespace {

constexpr std::string_view kForm = "give HOST:PORT, as in 127.0.0.1:7400, localhost:7400 or [::1]:7400";

/// `part` of `text` is quoted before `problem`; it may be empty.
auto malformed(std::string_view text, std::string_view part, std::string_view problem) {
  std::string reason;
  if (!part.empty()) reason.append("\"").append(part).append("\" ");
  return refused(std::string(text), reason.append(problem).append("; ").append(kForm));
}

bool isHostName(std::string_view host) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._";
  return !host.empty() && host.find_first_not_of(kLetters) == std::string_view::npos;
}

}  // namespace

std::string Endpoint::text() const {
  const bool ipv6 = host.find(':') != std::string::npos;
  return (ipv6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

Result<Endpoint> parseEndpoint(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return malformed(text, "", "has no port");
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);

  std::uint16_t port = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (digits.empty() || problem != std::errc() || end != digits.data() + digits.size()) {
    return malformed(text, digits, "is not a port from 0 to 65535");
  }

  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
    std::error_code error;
    asio::ip::make_address_v6(std::string(host), error);
    if (error) return malformed(text, host, "is not an IPv6 address");
    return Endpoint{std::string(host), port};
  }
  if (host.find(':') != std::string_view::npos)
    return malformed(text, host, "has colons: an IPv6 address needs brackets");
  if (host == "localhost") return Endpoint{"127.0.0.1", port};
  const bool numeric = !host.empty() && host.find_first_not_of("0123456789.") == std::string_view::npos;
  std::error_code error;
  if (numeric) asio::ip::make_address_v4(std::string(host), error);
  if (error || !isHostName(host)) return malformed(text, host, "is not a host");
  return Endpoint{std::string(host), port};
}

bool isLoopback(const Endpoint& endpoint) {
  std::error_code error;
  const asio::ip::address address = asio::ip::make_address(endpoint.host, error);
  return !error && address.is_loopback();
}

Result<void> checkListenAddress(const Endpoint& endpoint, bool securedOrTrusted) {
  if (securedOrTrusted || isLoopback(endpoint)) return {};
  return refused(
      "--listen " + endpoint.text(),
      "other machines can reach it; make credentials with \"hapticctl credentials DIR\" and add --credentials "
      "DIR, or add --allow-insecure-lan on a network where everybody may read and edit");
}

}  // namespace haptics
