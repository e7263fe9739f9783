// Implements `raygraph denoise`.
#include "editor/session/denoise.h"

#include <memory>

#include "base/files.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/outputs.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

namespace {

RenderFile ReadInput(const std::filesystem::path& file, const Log& log) {
    try {
        return ReadRenderFile(file, log);
    } catch (const Error& error) {
        if (error.Kind() != ErrorKind::BadInput || LowerExtension(file) == ".exr") throw;
        throw MakeError(error.Kind(), "{}; denoise reads an .exr of `raygraph render --aov denoising`",
                        error.what());
    }
}

}  // namespace

ExitCode DenoiseCommand(const DenoiseArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    RenderFile render = ReadInput(arguments.input, log);
    if (const std::string why = NotDenoisableReason(render); !why.empty())
        throw MakeError(ErrorKind::BadInput, "{} cannot be denoised: {}", arguments.input, why);
    if (render.denoising.albedo.empty())
        console.log.Warn(
            Text("{} was rendered without --aov denoising: edges of lights keep their noise, and details may "
                 "suffer",
                 arguments.input));
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    const image::Image8 display =
        Denoise(*device, render, DisplayOf(arguments), arguments.denoiser.value_or(FileDenoiser::Network));
    console.log.RequireValid();
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    for (const OutputFile& output : arguments.outputs)
        outputs.Add(output.path, [&] {
            if (output.kind == OutputKind::Png)
                image::WritePng(output.path, display);
            else
                WriteRenderFile(output.path, render, log);
        });
    outputs.WriteAll();
    if (!arguments.isQuiet)
        for (const std::filesystem::path& file : outputs.Written()) PrintLine(file.string());
    return outputs.Result();
}

}  // namespace raygraph::cli
