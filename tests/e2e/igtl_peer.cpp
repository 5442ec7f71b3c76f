// OpenIGTLink's own library as a program beside haptic_igtl would use it, for the end-to-end test.
//
// usage: igtl_peer read PORT SECONDS                     prints a line of JSON for each message
//        igtl_peer move PORT OBJECT HZ SECONDS MOTION    MOTION: circle, nan, skewed

#include <igtlClientSocket.h>
#include <igtlMessageHeader.h>
#include <igtlPositionMessage.h>
#include <igtlSensorMessage.h>
#include <igtlTransformMessage.h>
#include <igtlUnit.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

igtl::ClientSocket::Pointer connect(const std::string& port) {
  auto socket = igtl::ClientSocket::New();
  if (socket->ConnectToServer("127.0.0.1", std::stoi(port)) != 0) throw std::runtime_error("no connection");
  return socket;
}

template <class Type>
typename Type::Pointer receive(igtl::ClientSocket& socket, igtl::MessageHeader::Pointer header) {
  auto message = Type::New();
  message->SetMessageHeader(header);
  message->AllocatePack();
  socket.Receive(message->GetPackBodyPointer(), message->GetPackBodySize());
  if ((message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) == 0) throw std::runtime_error("a body with another CRC");
  return message;
}

void read(const std::vector<std::string>& arguments) {
  const auto socket = connect(arguments.at(1));
  socket->SetReceiveTimeout(2000);
  const auto end = Clock::now() + std::chrono::duration<double>(std::stod(arguments.at(2)));
  while (Clock::now() < end) {
    auto header = igtl::MessageHeader::New();
    header->InitPack();
    if (socket->Receive(header->GetPackPointer(), header->GetPackSize()) != header->GetPackSize()) break;
    header->Unpack();
    const std::string type = header->GetDeviceType();
    unsigned int seconds = 0, fraction = 0;
    header->GetTimeStamp(&seconds, &fraction);
    std::printf(R"({"type": "%s", "name": "%s", "time_s": %.9f)", type.c_str(), header->GetDeviceName(),
                seconds + std::ldexp(fraction, -32));
    if (type == "TRANSFORM") {
      igtl::Matrix4x4 m;
      receive<igtl::TransformMessage>(*socket, header)->GetMatrix(m);
      std::printf(R"(, "at": [%.9g, %.9g, %.9g], "x": [%.9g, %.9g, %.9g], "y": [%.9g, %.9g, %.9g])", m[0][3], m[1][3],
                  m[2][3], m[0][0], m[1][0], m[2][0], m[0][1], m[1][1], m[2][1]);
    } else if (type == "POSITION") {
      float at[3] = {}, q[4] = {};
      const auto position = receive<igtl::PositionMessage>(*socket, header);
      position->GetPosition(at);
      position->GetQuaternion(q);
      std::printf(R"(, "at": [%.9g, %.9g, %.9g], "turned": [%.9g, %.9g, %.9g, %.9g])", at[0], at[1], at[2], q[0], q[1],
                  q[2], q[3]);
    } else if (type == "SENSOR") {
      const auto sensor = receive<igtl::SensorMessage>(*socket, header);
      auto newton = igtl::Unit::New();
      newton->Append(igtl::Unit::SI_DERIVED_NEWTON, 1);
      const bool newtons = sensor->GetUnit() == newton->Pack();
      std::printf(R"(, "newtons": %s, "values": [%.17g, %.17g, %.17g])", newtons ? "true" : "false",
                  sensor->GetValue(0), sensor->GetValue(1), sensor->GetValue(2));
    } else {
      throw std::runtime_error("a message of type " + type);
    }
    std::printf("}\n");
  }
  socket->CloseSocket();
}

void move(const std::vector<std::string>& arguments) {
  const auto socket = connect(arguments.at(1));
  const std::string& motion = arguments.at(5);
  const double rate_Hz = std::stod(arguments.at(3)), seconds = std::stod(arguments.at(4));
  const auto began = Clock::now();
  for (double t = 0; t < seconds; t += 1 / rate_Hz) {
    std::this_thread::sleep_until(began +
                                  std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(t)));
    const auto turn = static_cast<float>(t);
    const float x = motion == "nan" ? std::numeric_limits<float>::quiet_NaN() : 50 * std::cos(3 * turn);
    igtl::Matrix4x4 m = {{std::cos(turn), -std::sin(turn), 0, x},
                         {std::sin(turn), std::cos(turn), 0, 50 * std::sin(3 * turn)},
                         {0, 0, motion == "skewed" ? 1.1F : 1, 25},
                         {0, 0, 0, 1}};
    auto message = igtl::TransformMessage::New();
    message->SetDeviceName(arguments.at(2).c_str());
    message->SetMatrix(m);
    message->Pack();
    if (socket->Send(message->GetPackPointer(), message->GetPackSize()) == 0) throw std::runtime_error("not sent");
  }
  socket->CloseSocket();
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    const std::string& verb = arguments.at(0);
    if (verb == "read") return read(arguments), 0;
    if (verb == "move") return move(arguments), 0;
    std::fprintf(stderr, "igtl_peer: read or move\n");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "igtl_peer: %s\n", error.what());
  }
  return 1;
}
