// Files of IES LM-63 under construction, for tests.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/text.h"

namespace raygraph::test {

struct IesText {
    std::string version = "IESNA:LM-63-2002";
    std::string tilt = "TILT=NONE";
    int type = 1;  // 1: C, 2: B, 3: A
    std::vector<double> vertical{0, 90}, horizontal{0};
    std::function<double(double v, double h)> candela = [](double, double) { return 100.0; };
    double multiplier = 1.0, ballast = 1.0, ballastLamp = 1.0;

    std::string Text() const {
        std::string text = version + "\r\n[TEST] of a test\r\n[MANUFAC] nobody\r\n" + tilt + "\r\n";
        text += raygraph::Text("1 -1 {} {} {} {} 2 0 0 0\r\n{} {} 50\r\n", multiplier, vertical.size(),
                               horizontal.size(), type, ballast, ballastLamp);
        const auto list = [&](const std::vector<double>& values) {
            for (const double value : values) text += raygraph::Text("{} ", value);
            text += "\r\n";
        };
        list(vertical);
        list(horizontal);
        for (const double h : horizontal) {
            for (const double v : vertical) text += raygraph::Text("{} ", candela(v, h));
            text += "\r\n";
        }
        return text;
    }
};

// Returns the angles from one to another.
inline std::vector<double> Steps(double from, double to, double step) {
    std::vector<double> angles;
    for (int i = 0; from + i * step < to + 1e-9; ++i) angles.push_back(from + i * step);
    return angles;
}

}  // namespace raygraph::test
