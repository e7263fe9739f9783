// A scene reads what stands in its own folder and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>

#include "renderer/scene/gltf/file_access.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test::file_access_test {
namespace {

namespace fs = std::filesystem;

// A triangle whose positions are in the file that `uri` names.
GltfDocument WithBufferUri(const std::string& uri) {
    GltfDocument document;
    document.AddTriangle();
    document.json["buffers"][0]["uri"] = uri;
    return document;
}

const Bytes kPositions = BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});

// Returns the error about the URI, without the part that every message has.
std::string UriError(SceneFolder& folder, const std::string& uri) {
    const std::string message = folder.LoadError(WithBufferUri(uri));
    const std::string start = "scene.gltf: buffers[0].uri: ";
    EXPECT_EQ(message.find(start), 0u) << message;
    return message.substr(std::min(start.size(), message.size()));
}

TEST(FileAccess, FilesBesideTheSceneAreRead) {
    SceneFolder folder;
    folder.Write("a b.bin", kPositions);
    folder.Write("deep/er/data.bin", kPositions);
    EXPECT_EQ(folder.LoadError(WithBufferUri("a b.bin")), "loaded");
    EXPECT_EQ(folder.LoadError(WithBufferUri("a%20b.bin")), "loaded");
    EXPECT_EQ(folder.LoadError(WithBufferUri("./deep/er/data.bin")), "loaded");
    EXPECT_EQ(folder.reads.back(), folder.Path() / "deep/er/data.bin");
}

// Returns the message that refuses a URI that leads out.
std::string Outside(const std::string& uri) {
    return '"' + uri +
           "\": leads out of the scene's folder; --root FOLDER allows what is below another folder";
}

TEST(FileAccess, DotsAreResolvedBeforeTheUriIsChecked) {
    SceneFolder folder;
    folder.Write("own.bin", kPositions);
    const std::string name = folder.Path().filename().string();
    for (const std::string uri : {"sub/../own.bin", "a/b/../../own.bin", "./x/./../own.bin",
                                  "sub/%2e%2e/own.bin", "sub%2F..%2fown.bin", "sub//../own.bin"})
        EXPECT_EQ(folder.LoadError(WithBufferUri(uri)), "loaded") << uri;
    EXPECT_EQ(folder.LoadError(WithBufferUri("../" + name + "/own.bin")), "loaded") << "out, and in again";
    EXPECT_EQ(folder.reads.back(), folder.Path() / "own.bin");
    // ".." is resolved in the text of the URI, not where a link leads
    const SceneFolder outside;
    outside.Write("inner/secret.bin", kPositions);
    outside.Write("own.bin", "none of the scene's");
    fs::create_directory_symlink(outside.Path() / "inner", folder.Path() / "link");
    EXPECT_EQ(folder.LoadError(WithBufferUri("link/../own.bin")), "loaded");
    EXPECT_EQ(folder.reads.back(), folder.Path() / "own.bin");
}

TEST(FileAccess, UrisThatLeadOutAreRefusedUnread) {
    SceneFolder folder;
    folder.Write("inner/keep.txt", "");
    for (const std::string uri :
         {"../secret.bin", "inner/../../secret.bin", "%2e%2e/secret.bin", "%2E%2E%2Fsecret.bin", "..",
          "../..", "inner/../..", "../../../../../../../../../../etc/passwd"})
        EXPECT_EQ(UriError(folder, uri), Outside(uri));
    EXPECT_EQ(UriError(folder, "/etc/passwd"),
              "\"/etc/passwd\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "%2Fetc/passwd"),
              "\"%2Fetc/passwd\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "//host/share"),
              "\"//host/share\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "file:///etc/passwd"),
              "\"file:///etc/passwd\": must be a relative path or a data URI, not \"file\"");
    EXPECT_EQ(UriError(folder, "http://example.com/x"),
              "\"http://example.com/x\": must be a relative path or a data URI, not \"http\"");
    EXPECT_EQ(UriError(folder, "C:\\x.bin"),
              "\"C:\\x.bin\": must be a relative path or a data URI, not \"C\"");
    EXPECT_EQ(UriError(folder, "..\\x.bin"), "\"..\\x.bin\": contains a backslash");
    EXPECT_EQ(UriError(folder, "a%00b"), "\"a%00b\": contains a zero byte");
    EXPECT_EQ(UriError(folder, ""), "\"\": is empty");
    for (const fs::path& path : folder.reads) EXPECT_EQ(path, folder.Path() / "scene.gltf");
}

TEST(FileAccess, SymbolicLinksOutOfTheFolderAreRefusedUnread) {
    const SceneFolder outside;
    outside.Write("data.bin", kPositions);
    SceneFolder folder;
    fs::create_symlink(outside.Path() / "data.bin", folder.Path() / "link.bin");
    fs::create_directory_symlink(outside.Path(), folder.Path() / "dir");
    EXPECT_EQ(UriError(folder, "link.bin"), Outside("link.bin"));
    EXPECT_EQ(UriError(folder, "dir/data.bin"), Outside("dir/data.bin"));
    for (const fs::path& path : folder.reads) EXPECT_EQ(path, folder.Path() / "scene.gltf");
}

TEST(FileAccess, FolderWhoseNameOnlyStartsAlikeIsOutside) {
    const TemporaryFolder outer;
    fs::create_directories(outer / "scene");
    fs::create_directories(outer / "scene-secret");
    std::ofstream(outer / "scene-secret/x.bin") << "x";
    fs::create_symlink(outer / "scene-secret/x.bin", outer / "scene/x.bin");
    scene::DiskFileReader disk;
    const scene::ConfinedFolder folder(outer / "scene", disk);
    EXPECT_THROW(folder.Read("x.bin", 100), Error);
}

// A folder with scene/scene.gltf, and textures and secrets beside it.
class RootTest : public ::testing::Test {
  protected:
    RootTest() : path(fs::canonical(outer.Path())) {
        for (const char* folder : {"scene", "textures/deep", "secrets"})
            fs::create_directories(path / folder);
        for (const char* file : {"scene/own.bin", "textures/x.bin", "textures/deep/y.bin", "secrets/z.bin"})
            Write(file, kPositions);
        fs::create_symlink(path / "secrets/z.bin", path / "textures/link.bin");
        fs::create_symlink(path / "textures/x.bin", path / "scene/in.bin");
    }
    void Write(const fs::path& file, const Bytes& bytes) const {
        std::ofstream(path / file, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    // Loads a scene that names the file by this URI. Returns "loaded", or the message about the URI.
    std::string Load(const std::string& uri, const fs::path& root) const {
        Write("scene/scene.gltf", ToBytes(WithBufferUri(uri).Text()));
        try {
            scene::LoadGltf(path / "scene/scene.gltf", {.root = root});
            return "loaded";
        } catch (const Error& error) {
            const std::string message = error.what(), start = "scene.gltf: buffers[0].uri: \"" + uri + "\": ";
            return message.starts_with(start) ? message.substr(start.size()) : message;
        }
    }
    TemporaryFolder outer;
    fs::path path;
};

TEST_F(RootTest, FilesBelowItAreReadBesidesThoseOfTheSceneFolder) {
    for (const char* uri : {"../textures/x.bin", "%2e%2e/textures/deep/../deep/y.bin", "own.bin", "in.bin"}) {
        EXPECT_EQ(Load(uri, path), "loaded") << uri;
        EXPECT_EQ(Load(uri, path / "scene/.."), "loaded") << uri;
        EXPECT_EQ(Load(uri, path / "textures"), "loaded") << uri << ": it need not be a folder above";
    }
    EXPECT_EQ(Load("../textures/link.bin", path), "loaded");
    EXPECT_EQ(Load("../textures/x.bin", {}),
              "leads out of the scene's folder; --root FOLDER allows what is below another folder");
}

TEST_F(RootTest, WhatLeadsOutOfItTooIsRefused) {
    const std::string outside =
        "leads out of the scene's folder and of the root \"" + (path / "textures").string() + '"';
    for (const char* uri : {"../secrets/z.bin", "../textures/../secrets/z.bin", "../textures/link.bin", "..",
                            "../../x.bin", "../textures-too/x.bin", "../textures"})
        EXPECT_EQ(Load(uri, path / "textures"), outside) << uri;
    EXPECT_EQ(Load((path / "textures/x.bin").string(), path), "must be a relative path, not an absolute one");
    EXPECT_THAT(Load("file://" + (path / "textures/x.bin").string(), path),
                ::testing::HasSubstr("must be a relative path or a data URI"));
    EXPECT_EQ(Load("../textures", path), "is not a regular file");
    ASSERT_EQ(mkfifo((path / "textures/pipe").c_str(), 0600), 0);
    EXPECT_EQ(Load("../textures/pipe", path), "is not a regular file");
    const std::string device = "../../../../../../../../../../../../dev/zero";
    EXPECT_EQ(Load(device, "/"), "is not a regular file");
    EXPECT_EQ(Load("../textures/gone.bin", path), "No such file or directory");
}

TEST_F(RootTest, ItMustBeAFolder) {
    EXPECT_EQ(Load("own.bin", path / "none"), (path / "none").string() + ": No such file or directory");
    EXPECT_EQ(Load("own.bin", path / "scene/own.bin"),
              (path / "scene/own.bin").string() + ": is not a folder");
}

TEST_F(RootTest, SavedElsewhereNothingIsWrittenOutsideOfTheTarget) {
    ASSERT_EQ(Load("../textures/x.bin", path), "loaded");
    const fs::path source = path / "scene/scene.gltf";
    const scene::LoadOptions options{.root = path};
    const scene::SceneData scene = scene::LoadGltf(source, options);
    // A scene saved in the folder beside it reaches the same file
    fs::create_directory(path / "other");
    scene::SaveGltf(source, scene, path / "other/saved.gltf", options);
    EXPECT_EQ(scene::LoadGltf(path / "other/saved.gltf", options).instances.size(), 1u);
    fs::create_directories(path / "far/away");
    EXPECT_EQ(
        testing::ErrorTextOf([&] { scene::SaveGltf(source, scene, path / "far/away/saved.gltf", options); },
                             ErrorKind::BadInput),
        "\"../textures/x.bin\": leads out of the scene's folder, and is not copied to " +
            (path / "far/away/../textures/x.bin").string());
    EXPECT_FALSE(fs::exists(path / "far/textures"));
    EXPECT_FALSE(fs::exists(path / "far/away/saved.gltf"));
    fs::create_directory(path / "far/textures");
    Write("far/textures/x.bin", ToBytes("another"));
    EXPECT_THROW(scene::SaveGltf(source, scene, path / "far/away/saved.gltf", options), Error);
}

TEST(FileAccess, SymbolicLinksWithinTheFolderAreFollowed) {
    SceneFolder folder;
    folder.Write("real/data.bin", kPositions);
    fs::create_symlink("real/data.bin", folder.Path() / "link.bin");
    EXPECT_EQ(folder.LoadError(WithBufferUri("link.bin")), "loaded");
}

TEST(FileAccess, ThingsThatAreNoFilesAreRefusedWithoutWaiting) {
    SceneFolder folder;
    ASSERT_EQ(mkfifo((folder.Path() / "pipe").c_str(), 0600), 0);
    fs::create_directory(folder.Path() / "folder");
    EXPECT_EQ(UriError(folder, "pipe"), "\"pipe\": is not a regular file");
    EXPECT_EQ(UriError(folder, "folder"), "\"folder\": is not a regular file");
    scene::DiskFileReader disk;
    EXPECT_THROW(disk.Read("/dev/zero", 100), Error);
}

TEST(FileAccess, MissingFilesAreRefusedByName) {
    SceneFolder folder;
    EXPECT_EQ(UriError(folder, "gone.bin"), "\"gone.bin\": No such file or directory");
}

TEST(FileAccess, FilesBeyondTheLimitAreRefusedUnread) {
    SceneFolder folder;
    folder.Write("big.bin", Bytes(5000));
    const GltfDocument document = WithBufferUri("big.bin");
    scene::LoadOptions options;
    options.limits.maxFileBytes = document.Text().size() + 4000;
    EXPECT_EQ(folder.LoadError(document, options),
              "scene.gltf: buffers[0].uri: \"big.bin\": 5000 bytes exceed the limit of 4000");
}

TEST(FileAccess, HostileUriIsQuotedInOneLine) {
    SceneFolder folder;
    EXPECT_EQ(UriError(folder, "a\nb\x1b[31m\xE2\x80\xA8.bin"),
              "\"a?b?[31m?.bin\": No such file or directory");
    EXPECT_LT(UriError(folder, std::string(100000, 'x')).size(), 200u);
}

TEST(FileAccess, MissingSceneIsAnIoError) {
    const SceneFolder folder;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::LoadGltf(folder.Path() / "none.glb"); }, ErrorKind::Io),
              (folder.Path() / "none.glb").string() + ": No such file or directory");
}

TEST(FileAccess, FolderAsSceneIsAnIoError) {
    const SceneFolder folder;
    EXPECT_EQ(testing::ErrorOf([&] { scene::LoadGltf(folder.Path()); }).Kind(), ErrorKind::Io);
}

TEST(FileAccess, LinkToASceneFindsWhatStandsBesideTheLink) {
    SceneFolder real;
    real.Write("scene.gltf", WithBufferUri("data.bin").Text());
    SceneFolder folder;
    folder.Write("data.bin", kPositions);
    fs::create_symlink(real.Path() / "scene.gltf", folder.Path() / "link.gltf");
    EXPECT_EQ(scene::LoadGltf(folder.Path() / "link.gltf").instances.size(), 1u);
}

}  // namespace
}  // namespace raygraph::test::file_access_test
