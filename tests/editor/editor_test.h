// EditorTest has an editor that plays scripts without a window.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "tests/support/current_folder.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor {

// Writes the text to `folder`/script.txt, and plays it.
inline void PlayText(const std::string& text, const std::filesystem::path& folder, Editor& editor,
                     Screen& screen) {
    const std::filesystem::path file = folder / "script.txt";
    std::ofstream(file) << text;
    Script(file).Play(editor, screen);
}

class EditorTest : public testing::VulkanTest {
  protected:
    // Raster pictures are without effects and end with their first sample: few tests look at them.
    explicit EditorTest(EditorOptions options = {}) : editor(Device(), std::move(options)) {
        editor.Work().view.SetRaster(
            {.shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false});
        viewport::BudgetSettings budget = editor.Work().view.Budget();
        budget.maxRasterSamples = 1;
        editor.Work().view.SetBudget(budget);
        editor.Work().UseLight(DefaultLight::None);  // the studio's map would be filtered for the empty scene
    }
    void Play(const std::string& text) { PlayText(text, folder.Path(), editor, screen); }
    static std::string OpenCornell() {
        return "size 640x400\nview raster\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
               "\nwait\n";
    }

    const test::TemporaryFolder folder;
    const test::CurrentFolder current{folder.Path()};  // files of default names are written there
    Editor editor;
    PictureScreen screen;
};

}  // namespace raygraph::editor
