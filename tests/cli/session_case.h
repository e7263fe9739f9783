// SessionCase is a scene with settings that tests of sessions render in different ways. It needs a device.
#pragma once

#include <ostream>

#include "editor/session/session.h"
#include "tests/cli/program_runner.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session {

struct SessionCase {
    const char* scene;
    SettingTexts settings;
    bool hasAll = false;  // all channels, and light groups
};

inline void PrintTo(const SessionCase& of, std::ostream* out) {
    *out << of.scene;
    for (const auto& [name, text] : of.settings) *out << " " << name << "=" << text;
    if (of.hasAll) *out << " with all channels";
}

class SessionCaseTest : public testing::VulkanTest, public ::testing::WithParamInterface<SessionCase> {
  protected:
    // Settings in `more` replace those of the case.
    static RenderFile RenderCase(const SessionCase& of, const SettingTexts& more, uint32_t samples,
                                 uint32_t batchSize = 0, const TracingChoice& tracing = {}) {
        SettingTexts texts = more;
        texts.insert(of.settings.begin(), of.settings.end());
        SessionDesc desc;
        desc.batchSize = batchSize;
        desc.tracing = tracing;
        desc.settings = SettingsFrom(texts);
        if (of.hasAll) {
            desc.settings.lightGroups = {{"all", {"*"}}};
            for (const Aov aov : kAovs) desc.aovs.Set(aov, CanHave(aov, desc.settings));
        }
        Session session(
            Device(), LoadInput(test::SceneFile(of.scene), {.pointsAndLines = desc.settings.pointsAndLines}),
            desc);
        session.Run({.samples = samples});
        EXPECT_EQ(session.NonFiniteSamples(), 0u);
        return std::move(session.Result()).render;
    }
};

}  // namespace raygraph::session
