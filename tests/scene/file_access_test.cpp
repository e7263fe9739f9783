// A scene reads what stands in its own folder and nothing else.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>

#include "renderer/scene/file_access.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test {
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

// What loading says of the URI, without the part that every message has.
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

TEST(FileAccess, UrisThatLeadOutAreRefusedUnread) {
    SceneFolder folder;
    folder.Write("inner/keep.txt", "");
    EXPECT_EQ(UriError(folder, "../secret.bin"),
              "\"../secret.bin\": leads out of the scene's folder (\"..\")");
    EXPECT_EQ(UriError(folder, "inner/../../secret.bin"),
              "\"inner/../../secret.bin\": leads out of the scene's folder (\"..\")");
    EXPECT_EQ(UriError(folder, "%2e%2e/secret.bin"),
              "\"%2e%2e/secret.bin\": leads out of the scene's folder (\"..\")");
    EXPECT_EQ(UriError(folder, "%2E%2E%2Fsecret.bin"),
              "\"%2E%2E%2Fsecret.bin\": leads out of the scene's folder (\"..\")");
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
    EXPECT_EQ(UriError(folder, "link.bin"), "\"link.bin\": leads out of the scene's folder");
    EXPECT_EQ(UriError(folder, "dir/data.bin"), "\"dir/data.bin\": leads out of the scene's folder");
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
}  // namespace raygraph::test
