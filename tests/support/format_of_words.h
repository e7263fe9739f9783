// Renders as the program stored them in files of format 3: each word of their sums as a channel of its own.
// Threads: pure functions.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "editor/session/file/render_file.h"
#include "renderer/image/exr.h"

namespace raygraph::test {

// `file` is what WriteRenderFile wrote of `render`.
inline image::ExrImage WithWordChannels(image::ExrImage file, const session::RenderFile& render) {
    std::erase_if(file.channels, [](const image::ExrChannel& channel) {
        return channel.name.find("sum") != std::string::npos ||
               channel.name.find("squares") != std::string::npos;
    });
    file.attributes["raygraph.format"] = "3";
    file.attributes.erase("raygraph.sumsDigest");
    // "albedo." and "RGB" become "albedo.sum0.R" and so on
    const auto add = [&](const std::string& prefix, const std::string& letters,
                         const passes::ExactSums& sums) {
        const auto addWord = [&](const char* what, size_t k, size_t channel,
                                 const passes::ExactSums::Plane& plane, size_t component) {
            std::vector<uint32_t> words(plane.size() / 4);
            for (size_t i = 0; i < words.size(); ++i) words[i] = plane[4 * i + component];
            file.channels.push_back({prefix + what + std::to_string(k) + "." + letters[channel], words});
        };
        for (size_t c = 0; c < letters.size() && !sums.IsEmpty(); ++c)
            for (size_t k = 0; k < 4; ++k) addWord("sum", k, c, sums.sums[k], c);
        for (size_t c = 0; c < 3 && sums.HasSquares(); ++c) {
            for (size_t k = 0; k < 4; ++k) addWord("squares", k, c, sums.squares[k], c);
            addWord("squares", 4, c, sums.squares[c], 3);
        }
    };
    add("", "RGBA", render.sums.radiance);
    for (const session::Aov aov : session::kAovs) {
        const passes::ExactSums* sums = SumsOf(render.sums, aov);
        if (sums == nullptr) continue;
        const bool isNormal = aov == session::Aov::Normal;
        add(isNormal ? "N." : std::string(Name(aov)) + ".", isNormal ? "XYZ" : "RGB", *sums);
    }
    const std::vector<std::string> groups =
        LightGroupNames(session::SettingsFrom(render.settings).lightGroups);
    for (size_t i = 0; i < render.sums.lightGroups.size(); ++i)
        add("light." + groups[i] + ".", "RGB", render.sums.lightGroups[i]);
    return file;
}

}  // namespace raygraph::test
