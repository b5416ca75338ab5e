// What a controller needs of rclcpp, stated: nothing of ROS is here.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace rclcpp {

class Duration {
public:
    explicit Duration(int64_t nanoseconds) : nanoseconds_(nanoseconds) {}
    double seconds() const { return static_cast<double>(nanoseconds_) / 1e9; }

private:
    int64_t nanoseconds_;
};

class Time {
public:
    explicit Time(int64_t nanoseconds = 0) : nanoseconds_(nanoseconds) {}
    Duration operator-(const Time &other) const { return Duration(nanoseconds_ - other.nanoseconds_); }

private:
    int64_t nanoseconds_;
};

struct QoS {};
struct SystemDefaultsQoS : QoS {};

template <typename Message>
struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
    std::function<void(typename Message::SharedPtr)> hears;
};

using ParameterValue = std::variant<bool, std::string, std::vector<double>>;

struct Parameter {
    ParameterValue value;
    bool as_bool() const { return std::get<bool>(value); }
    std::string as_string() const { return std::get<std::string>(value); }
    std::vector<double> as_double_array() const { return std::get<std::vector<double>>(value); }
};

}  // namespace rclcpp
