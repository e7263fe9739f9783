// Images of the scene, and files that take their place. What an image showed before keeps its textures on the
// device, so that undo and redo exchange them.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/app/document.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::editor {

namespace {

constexpr uint64_t kMaxImageBytes = uint64_t{1} << 30;

// Returns what the device needs for textures that show the image: these and the materials that read them,
// which say how levels are averaged.
scene::SceneData PartOf(const scene::SceneData& scene, const std::vector<uint32_t>& textures,
                        scene::ImageData&& image) {
    scene::SceneData part;
    part.images.push_back(std::move(image));
    for (const uint32_t texture : textures) {
        part.textures.push_back(scene.textures[texture]);
        part.textures.back().image = 0;
    }
    for (scene::Material material : scene.materials) {
        bool isReader = false;
        scene::ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>) {
                scene::TextureRef& reference = material.*field.member;
                if (!reference.IsPresent()) return;
                const auto found = std::ranges::find(textures, static_cast<uint32_t>(reference.texture));
                reference.texture =
                    found == textures.end() ? -1 : static_cast<int32_t>(found - textures.begin());
                isReader |= reference.IsPresent();
            }
        });
        if (isReader) part.materials.push_back(std::move(material));
    }
    return part;
}

}  // namespace

void Document::TakeImages(const scene::SceneData& data) {
    for (const scene::ImageData& image : data.images)
        m_images.push_back({.choices = {{.facts = {.name = image.name,
                                                   .file = image.file,
                                                   .width = image.width,
                                                   .height = image.height}}}});
    for (uint32_t texture = 0; texture < data.textures.size(); ++texture)
        m_images[data.textures[texture].image].choices.front().textures.push_back(texture);
}

ImageFacts Document::ImageOf(uint32_t texture) const {
    const EditedImage& image = m_images.at(m_scene.textures.at(texture).image);
    return image.choices[image.shown].facts;
}

void Document::ReplaceImage(uint32_t texture, const std::filesystem::path& file, GpuScene& gpu) {
    const uint32_t index = m_scene.textures.at(texture).image;
    auto bytes = std::make_shared<std::vector<std::byte>>(ReadFile(file, kMaxImageBytes));
    image::Image8 decoded = image::DecodeImage8(*bytes, file.string());
    scene::ImageData data{.name = file.stem().string(),
                          .width = decoded.width,
                          .height = decoded.height,
                          .rgba = std::move(decoded.rgba),
                          .blocks = std::move(decoded.blocks)};
    data.lowestAlpha = scene::LowestAlpha(data);
    EditedImage& image = m_images[index];
    EditedImage::Choice choice{.facts = {.name = data.name,
                                         .file = file.string(),
                                         .width = data.width,
                                         .height = data.height,
                                         .isReplaced = true},
                               .bytes = std::move(bytes),
                               .textures = {}};
    std::vector<uint32_t> own;  // the textures of the document
    for (uint32_t i = 0; i < m_scene.textures.size(); ++i)
        if (m_scene.textures[i].image == index) own.push_back(i);
    const AddedPart added = gpu.Add(PartOf(m_scene, own, std::move(data)));
    for (const uint32_t material : added.materials) gpu.RemoveMaterial(material);
    choice.textures = added.textures;
    image.choices.push_back(std::move(choice));
    Settle();
    try {
        Apply(ImageEdit{index, static_cast<uint32_t>(image.choices.size() - 1)}, gpu);
    } catch (...) {
        image.choices.pop_back();
        for (const uint32_t unused : added.textures) gpu.RemoveTexture(unused);
        throw;
    }
    Settle();
}

void Document::ShowImages(GpuScene& gpu) {
    for (EditedImage& image : m_images) {
        if (image.onDevice == image.shown) continue;
        std::vector<uint32_t>&before = image.choices[image.onDevice].textures,
        &now = image.choices[image.shown].textures;
        gpu.SwapTextures(before, now);
        std::swap(before, now);
        image.onDevice = image.shown;
        ++m_imageRevision;
    }
}

std::vector<scene::ReplacedImage> Document::ReplacedImages() const {
    std::vector<scene::ReplacedImage> replaced;
    for (uint32_t i = 0; i < m_images.size(); ++i) {
        const EditedImage::Choice& shown = m_images[i].choices[m_images[i].shown];
        if (shown.bytes) replaced.push_back({.image = i, .file = shown.facts.file, .bytes = *shown.bytes});
    }
    return replaced;
}

}  // namespace raygraph::editor
