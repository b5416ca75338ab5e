// Calls the controller class as a controller manager does, with the rows of a log, and the library for C with the same numbers: torques must be the same,
// bit by bit. called LOG.csv
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "tulip_controller_ros2_control/controller.hpp"

using tulip_controller_ros2_control::WalkingController;
using Row = std::map<std::string, double>;

constexpr double PLACE[3] = {0.01, -0.02, 0.03};

// What a sensor feels: moments about its own origin, above the sole.
static double state(const Row &row, const std::string &name) {
    const auto at = [&row](const std::string &column) {
        const auto found = row.find(column);
        return found == row.end() ? NAN : found->second;
    };
    const size_t slash = name.find('/');
    std::string of = name.substr(0, slash), quantity = name.substr(slash + 1);
    const auto center = [&](const char *axis, int k) {
        const double found = at(of + "/cop/" + axis);
        return (std::isfinite(found) ? found : PLACE[k]) - PLACE[k];
    };
    const auto force = [&](const char *axis) { return at(of + "/force/" + axis); };
    if (quantity == "torque.x") return center("y", 1) * force("z") + PLACE[2] * force("y");
    if (quantity == "torque.y") return -center("x", 0) * force("z") - PLACE[2] * force("x");
    const size_t dot = quantity.find('.');
    if (dot != std::string::npos) quantity[dot] = '/';
    return at(of + "/" + quantity);
}

int main(int count, char **arguments) {
    std::ifstream log(count > 1 ? arguments[1] : "");
    std::string line, cell;
    if (!std::getline(log, line)) return 2;
    std::vector<std::string> header;
    for (std::stringstream names(line); std::getline(names, cell, ',');) header.push_back(cell);

    WalkingController controller;
    const rclcpp_lifecycle::State from;
    using controller_interface::CallbackReturn;
    if (controller.on_init() != CallbackReturn::SUCCESS) return 3;
    for (const char *foot : {"right_foot_place", "left_foot_place"}) {
        controller.get_node()->parameters[foot] = std::vector<double>(PLACE, PLACE + 3);
    }
    controller.get_node()->parameters["learn_payload"] = true;
    controller.get_node()->parameters["motor_position"] = std::string("motor_position");
    if (controller.on_configure(from) != CallbackReturn::SUCCESS) return 4;
    const auto states = controller.state_interface_configuration().names;
    const auto commands = controller.command_interface_configuration().names;
    std::vector<double> measured(states.size()), asked(commands.size());
    for (const double &value : measured) controller.state_interfaces_.emplace_back(&value);
    if (controller.on_activate(from) != CallbackReturn::ERROR) return 5;  // No commands are claimed yet.
    for (double &value : asked) controller.command_interfaces_.emplace_back(&value);
    if (controller.on_activate(from) != CallbackReturn::SUCCESS) return 6;

    const size_t alignment = tulip_controller_alignment();
    const size_t size = (tulip_controller_size() + alignment - 1) / alignment * alignment;
    auto *direct = static_cast<tulip_controller *>(std::aligned_alloc(alignment, size));
    if (tulip_controller_init(direct, size) != 0) return 7;
    tulip_controller_learn_payload(direct, 1);

    auto &hears = static_cast<rclcpp::Subscription<geometry_msgs::msg::Twist> *>(
        controller.get_node()->subscription.get())->hears;
    size_t rows = 0;
    double farthest = 0.0;
    for (; std::getline(log, line); ++rows) {
        Row row;
        std::stringstream cells(line);
        for (const std::string &name : header) {
            if (!std::getline(cells, cell, ',')) cell.clear();
            row[name] = cell.empty() ? NAN : std::strtod(cell.c_str(), nullptr);
        }
        for (size_t k = 0; k < states.size(); ++k) measured[k] = state(row, states[k]);
        const double forward = rows >= 500 ? 0.3 : 0.0;
        const auto wanted = std::make_shared<geometry_msgs::msg::Twist>();
        wanted->linear.x = forward;
        hears(wanted);
        const int64_t nanoseconds = 1000000 * static_cast<int64_t>(rows);
        // A clock that begins anywhere.
        const rclcpp::Time time(1700000000000000000 + nanoseconds);
        if (controller.update(time, rclcpp::Duration(1000000)) != controller_interface::return_type::OK) return 8;

        tulip_controller_sensors sensors;
        sensors.time = static_cast<double>(nanoseconds) / 1e9;
        for (size_t k = 0; k < commands.size(); ++k) {
            const std::string joint = commands[k].substr(0, commands[k].find('/'));
            sensors.joint_position[k] = row[joint + "/position"];
            sensors.joint_velocity[k] = row[joint + "/velocity"];
            sensors.motor_position[k] = state(row, joint + "/motor_position");
        }
        const char *const axes[3] = {"x", "y", "z"}, *const feet[2] = {"right_foot", "left_foot"};
        for (int k = 0; k < 3; ++k) {
            sensors.angular_velocity[k] = row[std::string("imu/angular_velocity/") + axes[k]];
            sensors.specific_force[k] = row[std::string("imu/linear_acceleration/") + axes[k]];
        }
        for (int foot = 0; foot < 2; ++foot) {
            const std::string of = feet[foot];
            sensors.load[foot] = row[of + "/force/z"];
            for (int k = 0; k < 2; ++k) {
                // The same operations as the class has: so that bits are the same.
                const double z = sensors.load[foot];
                const double moment = state(row, of + (k == 0 ? "/torque.y" : "/torque.x"));
                const double aside = PLACE[2] * row[of + "/force/" + axes[k]];
                sensors.center[foot][k] = k == 0 ? PLACE[0] - (moment + aside) / z : PLACE[1] + (moment - aside) / z;
                const double logged = row[of + "/cop/" + axes[k]];
                if (z > 1.0) farthest = std::fmax(farthest, std::fabs(sensors.center[foot][k] - logged));
            }
        }
        const tulip_controller_velocity velocity = {forward, 0.0, 0.0};
        tulip_controller_actuators actuators;
        if (tulip_controller_step(direct, &sensors, &velocity, &actuators) != 0) return 9;
        if (std::memcmp(actuators.torque, asked.data(), sizeof actuators.torque) != 0) {
            std::fprintf(stderr, "row %zu differs\n", rows);
            return 10;
        }
        if (actuators.status != controller.status()) return 11;
    }
    if (controller.on_deactivate(from) != CallbackReturn::SUCCESS) return 12;
    for (const double torque : asked) {
        if (torque != 0.0) return 13;
    }
    std::free(direct);
    std::printf("%zu rows, centres of pressure within %.1e m\n", rows, farthest);
    return rows > 0 && farthest < 1e-6 ? 0 : 14;
}
