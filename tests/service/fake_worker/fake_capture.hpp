// The "capture" of the made-up worker: a file whose text says how to behave (main.cpp has the fields).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace subpixel::tests {

// Its JSON object; ends the process with 3 when the file does not begin as one.
nlohmann::json read_fake_capture(const std::string& path);

// What opening the file that `reach` names came to: "reach: done" or the reason.
std::string reached(const nlohmann::json& fake);

}  // namespace subpixel::tests
