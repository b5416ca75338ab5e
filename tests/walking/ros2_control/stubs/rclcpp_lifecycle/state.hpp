// Of rclcpp_lifecycle.
#pragma once
#include <memory>
#include <string>

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_lifecycle {

class State {};

class LifecycleNode {
public:
    rclcpp::Parameter get_parameter(const std::string &name) const { return {parameters.at(name)}; }

    template <typename Message, typename Callback>
    std::shared_ptr<rclcpp::Subscription<Message>> create_subscription(
        const std::string &, const rclcpp::QoS &, Callback callback) {
        auto made = std::make_shared<rclcpp::Subscription<Message>>();
        made->hears = callback;
        subscription = made;
        return made;
    }

    std::map<std::string, rclcpp::ParameterValue> parameters;
    std::shared_ptr<void> subscription;
};

}  // namespace rclcpp_lifecycle
