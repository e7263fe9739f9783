// The sample of docs/viewport.md compiles. It needs a window's events, so it does not run.
#include <vulkan/vulkan.h>
#include "viewport_headers.h"  // the page's includes, which must suffice for its sample

namespace {

// Stands for the window of an editor.
struct Host {
    bool IsOpen() const { return false; }
    bool IsDragging() const { return false; }
    bool IsClicked() const { return false; }
    void Select(const viewport::PickResult&) const {}
};

#include "show_in_panel.inc"

[[maybe_unused]] constexpr auto* kSample = &ShowInPanel;

}  // namespace
