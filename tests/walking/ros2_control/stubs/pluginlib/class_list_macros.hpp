// Of pluginlib: that the class derives from its base, and can be made.
#pragma once
#include <type_traits>
#define PLUGINLIB_EXPORT_CLASS(made, base) \
    static_assert(std::is_base_of_v<base, made> && std::is_default_constructible_v<made>);
