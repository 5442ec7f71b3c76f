#pragma once

#include "graphics_client/ros2/dds.h"
#include "ros2_messages.h"

namespace haptics {
namespace ros2 {

// As ROS 2 calls them.
using Time = builtin_interfaces_msg_dds__Time_;
using Header = std_msgs_msg_dds__Header_;
using ColorRGBA = std_msgs_msg_dds__ColorRGBA_;
using String = std_msgs_msg_dds__String_;
using Point = geometry_msgs_msg_dds__Point_;
using Vector3 = geometry_msgs_msg_dds__Vector3_;
using Quaternion = geometry_msgs_msg_dds__Quaternion_;
using PoseStamped = geometry_msgs_msg_dds__PoseStamped_;
using TwistStamped = geometry_msgs_msg_dds__TwistStamped_;
using WrenchStamped = geometry_msgs_msg_dds__WrenchStamped_;
using TransformStamped = geometry_msgs_msg_dds__TransformStamped_;
using Joy = sensor_msgs_msg_dds__Joy_;
using JointState = sensor_msgs_msg_dds__JointState_;
using TFMessage = tf2_msgs_msg_dds__TFMessage_;
using Marker = visualization_msgs_msg_dds__Marker_;
using MarkerArray = visualization_msgs_msg_dds__MarkerArray_;
using EditRequest = haptics_msgs_srv_dds__Edit_Request_;
using EditResponse = haptics_msgs_srv_dds__Edit_Response_;

}  // namespace ros2

namespace dds {

template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::String>() {
  return std_msgs_msg_dds__String__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::PoseStamped>() {
  return geometry_msgs_msg_dds__PoseStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::TwistStamped>() {
  return geometry_msgs_msg_dds__TwistStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::WrenchStamped>() {
  return geometry_msgs_msg_dds__WrenchStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::Joy>() {
  return sensor_msgs_msg_dds__Joy__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::JointState>() {
  return sensor_msgs_msg_dds__JointState__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::TFMessage>() {
  return tf2_msgs_msg_dds__TFMessage__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::MarkerArray>() {
  return visualization_msgs_msg_dds__MarkerArray__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::EditRequest>() {
  return haptics_msgs_srv_dds__Edit_Request__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptorOf<ros2::EditResponse>() {
  return haptics_msgs_srv_dds__Edit_Response__desc;
}

}  // namespace dds
}  // namespace haptics
