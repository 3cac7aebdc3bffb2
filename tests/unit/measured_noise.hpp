// Logarithms of fxaa's processor time over those of msaa and noaa, less their medians: 20 rounds of grass at 160x90 by
// 4 processes on 2 cores of an EPYC while compilers, a browser and a game wanted 10 (load), Mesa 25.0.7, least of 5
// runs, 2 frames.
#pragma once

#include <array>
#include <utility>

namespace subpixel::server {

inline constexpr std::array<std::pair<double, double>, 20> kMeasuredLogRatios{{
    {-0.0241, -0.0429}, {-0.0388, -0.1933}, {0.3390, 0.3570},   {0.1295, 0.3674},   {0.2249, -0.0011},
    {-0.0352, 0.0237},  {-0.0575, -0.0015}, {-0.0263, -0.1401}, {0.0972, 0.0011},   {-0.0773, -0.0969},
    {-0.0205, 0.1783},  {-0.0181, 0.0452},  {-0.0405, 0.0424},  {0.1451, -0.1133},  {0.2991, 0.4618},
    {0.1173, -0.0012},  {0.0985, 0.0210},   {0.0181, -0.0898},  {-0.0486, -0.0436}, {0.2779, 0.1578},
}};

}  // namespace subpixel::server
