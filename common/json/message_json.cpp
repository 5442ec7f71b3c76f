#include "common/json/message_json.h"

#include <google/protobuf/descriptor.h>

#include <cstdlib>
#include <string>
#include <string_view>

namespace haptics {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

std::string hexDigits(std::string_view bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

Json textOrHex(const FieldDescriptor& field, const std::string& value) {
  return field.type() == FieldDescriptor::TYPE_BYTES ? hexDigits(value) : value;
}

Json singleToJson(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection.GetInt64(message, &field);
    case FieldDescriptor::CPPTYPE_UINT32:
      return reflection.GetUInt32(message, &field);
    case FieldDescriptor::CPPTYPE_UINT64:
      return reflection.GetUInt64(message, &field);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_FLOAT:
      return reflection.GetFloat(message, &field);
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.GetBool(message, &field);
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection.GetEnum(message, &field)->name();
    case FieldDescriptor::CPPTYPE_STRING:
      return textOrHex(field, reflection.GetString(message, &field));
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return toJson(reflection.GetMessage(message, &field));
  }
  std::abort();  // there is no other
}

// The protocol repeats messages, text and whole numbers.
Json repeatedToJson(const Message& message, const FieldDescriptor& field) {
  const auto& reflection = *message.GetReflection();
  Json list = Json::array();
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE:
        list.push(toJson(reflection.GetRepeatedMessage(message, &field, i)));
        break;
      case FieldDescriptor::CPPTYPE_STRING:
        list.push(textOrHex(field, reflection.GetRepeatedString(message, &field, i)));
        break;
      case FieldDescriptor::CPPTYPE_UINT64:
        list.push(reflection.GetRepeatedUInt64(message, &field, i));
        break;
      case FieldDescriptor::CPPTYPE_UINT32:
        list.push(std::uint64_t{reflection.GetRepeatedUInt32(message, &field, i)});
        break;
      case FieldDescriptor::CPPTYPE_DOUBLE:
        list.push(reflection.GetRepeatedDouble(message, &field, i));
        break;
      case FieldDescriptor::CPPTYPE_FLOAT:
        list.push(static_cast<double>(reflection.GetRepeatedFloat(message, &field, i)));
        break;
      default:
        break;
    }
  }
  return list;
}

}  // namespace

Json toJson(const google::protobuf::Message& message) {
  Json object{};
  const auto& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    if (field.is_repeated()) {
      object.set(field.name(), repeatedToJson(message, field));
    } else if (!field.has_presence() || message.GetReflection()->HasField(message, &field)) {
      object.set(field.name(), singleToJson(message, field));
    }
  }
  return object;
}

}  // namespace haptics
