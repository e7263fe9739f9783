// Makes seeds of texts and of stored renders.
#include "tests/fuzz/seeds.h"
#include "tests/support/ies_text.h"

namespace raygraph::fuzz {

namespace {

Seed Text(const std::string& name, std::string_view text, int first = -1) {
    const Input input = AsInput(text);
    Seed seed{name, {input.begin(), input.end()}};
    if (first >= 0) seed.bytes.insert(seed.bytes.begin(), static_cast<std::byte>(first));
    return seed;
}

}  // namespace

std::vector<Seed> SettingsSeeds() {
    return {
        Text("empty", "{}"),
        Text("all", R"({"panels": {"hierarchy": true, "inspector": false, "statistics": true, "graph": false,
"help": true}, "window": {"width": 1440, "height": 900}, "view": {"view": "path-traced", "tonemap": "Neutral",
"exposure": -1.5, "wipe": 0.25, "maxError": 0.5}, "gizmo": {"tool": "rotate", "space": "local",
"pivot": "origin"}, "recent": ["/a/b.gltf", "/c.glb"]})")};
}

// Makes profiles of each photometric type, with parts that symmetry completes.
std::vector<Seed> ProfileSeeds() {
    const auto quarter = [](double v, double h) { return 90.0 - v + h; };
    return {
        Text("all_around", test::IesText{.candela = [](double v, double) { return 180.0 - v; }}.Text()),
        Text("quarters", test::IesText{.horizontal = {0, 45, 90}, .candela = quarter}.Text()),
        Text("halves",
             test::IesText{.version = "IESNA91", .horizontal = {90, 180, 270}, .ballastLamp = 0.5}.Text()),
        Text("turn", test::IesText{.version = "IES:LM-63-2019",
                                   .tilt = "TILT=INCLUDE\r\n1\r\n2\r\n0 90\r\n1 0.5",
                                   .vertical = {0, 10, 180},
                                   .horizontal = {0, 120, 240}}
                         .Text()),
        Text("b", test::IesText{.type = 2, .vertical = {-90, 90}, .horizontal = {0, 90}}.Text()),
        Text("a", test::IesText{.type = 3, .vertical = {-90, 0, 90}, .horizontal = {-90, 90}}.Text())};
}

std::vector<Seed> ScriptSeeds() {
    return {Text("session",
                 "size 1280x720\nscale 2\nopen a b.gltf  # a comment\nwait\nview path-traced\n"
                 "samples 16\nmouse 640 360.5\nclick left\ndrag right 100 -3\nwheel -2\n"
                 "key ctrl+shift+z\nkey escape\ntext gr\xC3\xBC\xC3\x9F\nframes 10\n"),
            Text("files",
                 "window a.png\npicture b.exr\nbudget 0\nconfig c\nscene d.glb\nclose\n"
                 "press middle\nrelease middle\nmaterial base 1 0.5 0\n"),
            Text("expect",
                 "expect selected a lamp\nexpect view side by side\nexpect message saved\n"
                 "expect edits 3\nexpect asking yes\nexpect leaving no\nexpect samples-below 4\n"
                 "expect samples-above 0\n")};
}

std::vector<Seed> GraphFileSeeds() {
    return {Text("whole", R"({"textures": {"a": {"file": "a.png", "format": "rgba8"},
"b": {"size": "a", "layers": 3}, "c": {"size": [64, 32], "persistent": true, "file": "c.bin"}},
"buffers": {"d": {"bytes": 1024}, "e": {"file": "e.bin"}},
"passes": [{"shader": "a.comp", "bind": {"x": "a", "y": "d"}, "push": {"p": [1, 0.5], "f": "frame"},
"specialize": {"N": 3}, "dispatch": "a", "queue": "compute"}, {"shader": "a.comp", "dispatch": [1, 2, 3]},
{"name": "z", "shader": "b.frag", "targets": ["b"]}],
"outputs": {"a.png": "b", "b.bin": "d", "c.exr": {"texture": "b", "layer": 2}}, "frames": 4})"),
            Text("small", R"({"passes": [], "outputs": {"a.bin": "b"}, "buffers": {"b": {"bytes": 4}}})")};
}

// The first byte selects a kind of RunTexts.
std::vector<Seed> TextSeeds() {
    return {
        Text("render",
             "render\na.gltf\n-o\na.png\n--spp\n8\n--size\n64x48\n--aov\nalbedo,normal\n--light-group\na=b*",
             0),
        Text("bench", "bench\na.gltf\n--rounds=3\n--compare\nb.json\n--tolerance\n0.1", 0),
        Text("info", "info\n--devices", 0),
        Text("edit", "edit\na.gltf\n--headless-script\nb.txt\n--validate", 0),
        Text("merge", "merge\na.exr\nb.exr\n-o\nc.exr", 0),
        Text("graph", "graph\na.gltf\n--dot\n--first", 0),
        Text("pictures",
             "size=64x48\nview=normals\ncamera=1\naperture=0.1\nfocus=2\nseed=7\nsampler=sobol\n"
             "brdf=lambert\nnee=off\nmis=power\nrr=throughput\nrr-start=3\nmax-depth=none",
             1),
        Text("biases",
             "clamp-indirect=none\nregularize=0.5\nshadow-terminator=off\nbackground=0.5,0.5,1\n"
             "env-rotation=90\nenv-tint=1,1,1\nlight-group=lamp=l*,b;sky=*",
             1),
        Text("groups", "lamps=lamp*,bulb;sky=[a-c]?", 2),
        Text("eye_and_target", "1 2 3 0 0 0", 3),
        Text("whole_view", "1,2,3,0,0,0,0,1,0,2.5m", 3),
        Text("camera", "front", 3),
        Text("ranges", "0-63 128-191", 4),
        Text("run", R"({"scene": "b/a.gltf", "device": "d", "settings": {"size": "8x8", "seed": "1"}, "cost":
{"limit_path_version": 1, "measure": "cpu seconds", "median": 2.5, "standard_error": 0.01}})",
             5),
        Text("runs",
             "{\"scene\": \"x.gltf\"}\n\n{\"scene\": \"a.gltf\", \"device\": \"d\", \"settings\": {}, "
             "\"cost\": {\"limit_path_version\": 1, \"measure\": \"cpu seconds\", \"median\": 2, "
             "\"standard_error\": 0}}",
             5),
    };
}

// The bytes are a flag, the number of changes, the changes of four bytes each (kind, channel or attribute,
// value), and lines of text.
std::vector<Seed> RenderFileSeeds() {
    std::vector<Seed> seeds;
    // Starts with everything that may be stored, with the minimum, or with pixels of different numbers of
    // samples
    const std::pair<const char*, std::string> starts[] = {
        {"full", {1}}, {"small", {0, 0}}, {"adaptive", {0, 1}}};
    for (const auto& [name, start] : starts) {
        seeds.push_back(Text(name, start));
        for (char kind = 0; kind < 6; ++kind)
            for (const char at : std::string("\1\11\17\24"))
                seeds.push_back(Text(name + std::to_string(kind) + "_" + std::to_string(at),
                                     start + std::string{1, kind, at, 0, 3} + "0-3 7-9\n"));
    }
    return seeds;
}

}  // namespace raygraph::fuzz
