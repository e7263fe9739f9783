// offline_render SCENE PICTURE.exr PICTURE.png: renders as the command line does, in a program of its own.
#include <cstdio>

#include "editor/session/session.h"
#include "renderer/image/image.h"

using namespace raygraph;  // NOLINT: an example

int main(int argc, char** argv) {
    if (argc != 4) return 2;
    const auto device = rhi::Device::Create();  // or one that was adopted
    session::Session session(*device, session::LoadInput(argv[1]),
                             {.settings = {.size = {64, 48}},
                              .aovs = {session::Aov::Albedo, session::Aov::Normal, session::Aov::Depth}});
    session.Run({.samples = 8});  // or .seconds, .relativeError, .isStopRequested
    session::WriteRenderFile(argv[2], session.Result().render);
    image::WritePng(argv[3], session.Display());
}
