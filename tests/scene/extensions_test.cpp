// The list of extensions is true: the importer reads those that it says, each has its test, and the page has all.
#include "renderer/scene/extensions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>

#include "renderer/scene/gltf_schema.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/source_file.h"

namespace raygraph::test {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const fs::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Extensions, FileMayRequireThoseThatAreReadAndNoOthers) {
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        GltfDocument document;
        document.AddTriangle();
        document.json["extensionsRequired"] = {std::string(extension.name)};
        const std::string refusal = "scene.gltf: extensionsRequired[0]: the file requires \"" +
                                    std::string(extension.name) + "\", which is not supported";
        EXPECT_EQ(LoadError(document), extension.isRead ? "loaded" : refusal);
    }
}

TEST(Extensions, WhatTheTablesHoldIsRead) {
    for (const scene::Extension& row : scene::SupportedExtensions()) {
        const auto found = std::ranges::find(scene::KnownExtensions(), row.name, &scene::GltfExtension::name);
        ASSERT_NE(found, scene::KnownExtensions().end()) << row.name;
        EXPECT_TRUE(found->isRead) << row.name;
    }
}

TEST(Extensions, EachThatIsReadHasATestAndOthersAReason) {
    std::set<std::string> tests;
    const std::regex pattern(R"(\bTEST(_F|_P)?\((\w+),\s*(\w+)\))");
    for (const auto& entry : fs::recursive_directory_iterator(SourceFile("tests"))) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = TextOf(entry.path());
        for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
            tests.insert((*match)[2].str() + "." + (*match)[3].str());
    }
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        EXPECT_FALSE(extension.note.empty()) << extension.name;
        EXPECT_EQ(extension.isRead, tests.contains(std::string(extension.test)))
            << extension.name << ": " << extension.test;
    }
}

TEST(Extensions, PageNamesEachThatIsRead) {
    const std::string page = TextOf(SourceFile("docs/gltf.md")) + TextOf(SourceFile("docs/materials.md"));
    for (const scene::GltfExtension& extension : scene::KnownExtensions()) {
        const bool isNamed = page.find("`" + std::string(extension.name) + "`") != std::string::npos;
        EXPECT_TRUE(isNamed || !extension.isRead) << extension.name;
    }
}

}  // namespace
}  // namespace raygraph::test
