#include "editor/session/file/content_hash.h"

// The hash is compiled in, so that hosts need no library for it.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "editor/session/file/content_hasher.h"

namespace raygraph::session {

namespace {

template <typename T>
std::string TextOf(const T& content) {
    ContentHasher hasher;
    hasher.Add(content);
    return hasher.Text();
}

}  // namespace

struct ContentHasher::State {
    XXH3_state_t state;
};

ContentHasher::ContentHasher() : m_state(std::make_unique<State>()) {
    XXH3_64bits_reset(&m_state->state);
}

ContentHasher::~ContentHasher() = default;

void ContentHasher::AddBytes(const void* bytes, size_t size) {
    XXH3_64bits_update(&m_state->state, bytes, size);
}

std::string ContentHasher::Text() const {
    constexpr std::string_view kDigits = "0123456789abcdef";
    const uint64_t hash = XXH3_64bits_digest(&m_state->state);
    std::string text;
    for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(hash >> shift) & 15];
    return text;
}

std::string HashOf(const scene::SceneData& scene) {
    return TextOf(scene);
}

std::string HashOf(const image::ImageF& image) {
    return TextOf(image);
}

}  // namespace raygraph::session
