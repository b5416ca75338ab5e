// Of controller_interface and hardware_interface. With OPTIONAL_VALUES as newer releases have it, else as older ones.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "rclcpp_lifecycle/state.hpp"

namespace hardware_interface {

class LoanedStateInterface {
public:
    explicit LoanedStateInterface(const double *value) : value_(value) {}
#ifdef OPTIONAL_VALUES
    template <typename T = double>
    std::optional<T> get_optional() const { return *value_; }
#else
    double get_value() const { return *value_; }
#endif

private:
    const double *value_;
};

class LoanedCommandInterface {
public:
    explicit LoanedCommandInterface(double *value) : value_(value) {}
#ifdef OPTIONAL_VALUES
    [[nodiscard]] bool set_value(double value) {
        *value_ = value;
        return true;
    }
#else
    void set_value(double value) { *value_ = value; }
#endif

private:
    double *value_;
};

}  // namespace hardware_interface

namespace controller_interface {

enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };

struct InterfaceConfiguration {
    interface_configuration_type type;
    std::vector<std::string> names;
};

class ControllerInterface {
public:
    ControllerInterface() : node_(std::make_shared<rclcpp_lifecycle::LifecycleNode>()) {}
    virtual ~ControllerInterface() = default;
    virtual CallbackReturn on_init() = 0;
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;

    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return node_; }

    template <typename T>
    T auto_declare(const std::string &name, const T &value) {
        node_->parameters[name] = value;
        return value;
    }

    // What the controller manager does.
    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;

private:
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_;
};

}  // namespace controller_interface
