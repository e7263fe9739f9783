#include "editor/graph_run/graph_file.h"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::graph_run {

namespace {

using GraphJson = nlohmann::ordered_json;

constexpr size_t kMaxDepth = 8;
constexpr size_t kMaxItems = 4096;  // of a list or an object
constexpr uint32_t kMaxSide = 16384;
constexpr uint32_t kMaxLayers = 2048;
constexpr uint32_t kMaxGroups = 65535;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 20;

[[noreturn]] void FailAt(std::string_view file, std::string_view path, std::string_view why) {
    throw MakeError(ErrorKind::BadInput, "{}: {}{}{}", Printable(file, 1024), Printable(path, 1024),
                    path.empty() ? "" : ": ", Printable(why, 1024));
}

// A value with the path that leads to it.
class Node {
  public:
    Node(const GraphJson& value, std::string path, std::string_view file)
        : m_value(&value), m_path(std::move(path)), m_file(file) {}

    [[noreturn]] void Fail(std::string_view why) const { FailAt(m_file, m_path, why); }
    const GraphJson& Value() const { return *m_value; }

    // Calls visit(key, node) for each member of an object.
    template <typename Visit>
    void ForEachMember(Visit&& visit) const {
        if (!m_value->is_object()) Fail("an object is expected");
        for (const auto& [key, value] : m_value->items()) {
            if (key.empty()) Fail("a name is empty");
            visit(key, Node(value, PathOf(key), m_file));
        }
    }
    // Throws for a key of the object that is not among these.
    void AllowKeys(std::initializer_list<std::string_view> allowed) const {
        ForEachMember([&](const std::string& key, const Node& member) {
            if (std::ranges::find(allowed, key) != allowed.end()) return;
            std::string known;
            for (const std::string_view each : allowed) known.append(known.empty() ? "" : ", ").append(each);
            member.Fail("there is no such key; there are " + known);
        });
    }
    std::optional<Node> Find(const char* key) const {
        const auto found = m_value->find(key);
        if (found == m_value->end()) return std::nullopt;
        return Node(*found, PathOf(key), m_file);
    }
    // Calls take(node) if the object has the key.
    template <typename Take>
    void IfThere(const char* key, Take&& take) const {
        if (const std::optional<Node> found = Find(key)) take(*found);
    }
    template <typename Visit>
    void ForEachItem(Visit&& visit) const {
        if (!m_value->is_array()) Fail("a list is expected");
        for (size_t i = 0; i < m_value->size(); ++i)
            visit(Node((*m_value)[i], Text("{}[{}]", m_path, i), m_file));
    }
    std::string String() const {
        if (!m_value->is_string()) Fail("a text is expected");
        auto text = m_value->get<std::string>();
        if (text.empty()) Fail("it is empty");
        return text;
    }
    bool Bool() const {
        if (!m_value->is_boolean()) Fail("true or false is expected");
        return m_value->get<bool>();
    }
    // Returns true and false as 1 and 0.
    double Number() const {
        if (m_value->is_boolean()) return m_value->get<bool>() ? 1.0 : 0.0;
        if (!m_value->is_number()) Fail("a number is expected");
        return m_value->get<double>();
    }
    uint64_t Integer(uint64_t least, uint64_t most) const {
        const bool isWhole = m_value->is_number_unsigned();
        const uint64_t value = isWhole ? m_value->get<uint64_t>() : 0;
        if (!isWhole || value < least || value > most)
            Fail(Text("a whole number from {} to {} is expected", least, most));
        return value;
    }
    uint32_t Count(uint32_t most) const { return static_cast<uint32_t>(Integer(1, most)); }
    // Reads a file that the description may name.
    std::filesystem::path File() const {
        const std::string text = String();
        const std::filesystem::path path = std::filesystem::path(text).lexically_normal();
        const bool isBelow = path.is_relative() && path.has_filename() && *path.begin() != "..";
        if (!isBelow || text.find('\0') != std::string::npos)
            Fail("a file below the folder of the description is expected");
        return path;
    }

  private:
    std::string PathOf(const std::string& key) const { return m_path.empty() ? key : m_path + "." + key; }

    const GraphJson* m_value;
    std::string m_path;
    std::string_view m_file;
};

// Formats of texels that passes write.
rhi::Format FormatOf(const Node& node) {
    const std::string text = node.String();
    std::string known;
    for (uint32_t i = 1; i < rhi::kFormatCount; ++i) {
        const auto format = static_cast<rhi::Format>(i);
        if (rhi::BlockSide(format) != 1 || rhi::IsDepth(format)) continue;
        if (text == rhi::Name(format)) return format;
        known.append(known.empty() ? "" : ", ").append(rhi::Name(format));
    }
    node.Fail(Quoted(text) + " is no format; there are " + known);
}

class Reader {
  public:
    explicit Reader(GraphFile& graph) : m_graph(graph) {}

    void Read(const Node& root) {
        root.AllowKeys({"textures", "buffers", "passes", "outputs", "frames"});
        root.IfThere("textures", [&](const Node& all) {
            all.ForEachMember([&](const std::string& name, const Node& node) { ReadTexture(name, node); });
        });
        root.IfThere("buffers", [&](const Node& all) {
            all.ForEachMember([&](const std::string& name, const Node& node) { ReadBuffer(name, node); });
        });
        root.IfThere("textures", [&](const Node& all) { CheckSizes(all); });
        if (!root.Find("passes")) root.Fail("it has no passes");
        root.Find("passes")->ForEachItem([&](const Node& node) { ReadPass(node); });
        if (!root.Find("outputs")) root.Fail("it has no outputs");
        root.Find("outputs")->ForEachMember(
            [&](const std::string& file, const Node& node) { ReadOutput(file, node); });
        if (m_graph.outputs.empty()) root.Find("outputs")->Fail("there are none");
        root.IfThere("frames", [&](const Node& node) { m_graph.frames = node.Count(kMaxFrames); });
    }

  private:
    void ReadTexture(const std::string& name, const Node& node);
    void ReadBuffer(const std::string& name, const Node& node);
    void CheckSizes(const Node& textures) const;
    void ReadPass(const Node& node);
    void ReadShader(FilePass& pass, const Node& node) const;
    std::string NameOf(const FilePass& pass, const Node& node) const;
    void ReadOutput(const std::string& file, const Node& node);
    std::string ResourceOf(const Node& node) const {
        const std::string name = node.String();
        if (!m_graph.textures.contains(name) && !m_graph.buffers.contains(name))
            node.Fail("there is neither a texture nor a buffer " + Quoted(name));
        return name;
    }
    std::string TextureOf(const Node& node) const {
        const std::string name = node.String();
        if (!m_graph.textures.contains(name)) node.Fail("there is no texture " + Quoted(name));
        return name;
    }

    GraphFile& m_graph;
};

void Reader::ReadTexture(const std::string& name, const Node& node) {
    node.AllowKeys({"size", "format", "layers", "persistent", "file"});
    FileTexture texture;
    node.IfThere("format", [&](const Node& format) { texture.format = FormatOf(format); });
    node.IfThere("persistent", [&](const Node& flag) { texture.isPersistent = flag.Bool(); });
    node.IfThere("layers", [&](const Node& layers) { texture.layers = layers.Count(kMaxLayers); });
    node.IfThere("file", [&](const Node& file) { texture.file = file.File(); });
    const bool isPicture = !texture.file.empty() && LowerExtension(texture.file) != ".bin";
    node.IfThere("size", [&](const Node& size) {
        if (isPicture) size.Fail("leave it out, since the picture in file has the size");
        if (size.Value().is_string()) {
            texture.sizeOf = size.String();
            return;
        }
        std::vector<uint32_t> sides;
        size.ForEachItem([&](const Node& side) { sides.push_back(side.Count(kMaxSide)); });
        if (sides.size() != 2) size.Fail("two numbers or the name of a texture are expected");
        texture.size = {sides[0], sides[1]};
        if (TextureBytes(texture.format, texture.size, texture.layers) > kMaxResourceBytes)
            size.Fail(Text("the texture has more than {}", BytesText(kMaxResourceBytes)));
    });
    if (isPicture && texture.layers != 1) node.Fail("the picture has one layer");
    if (!isPicture && !node.Find("size")) node.Fail("it has no size");
    m_graph.textures.emplace(name, std::move(texture));
}

void Reader::ReadBuffer(const std::string& name, const Node& node) {
    node.AllowKeys({"bytes", "persistent", "file"});
    if (m_graph.textures.contains(name)) node.Fail("there is a texture of that name");
    FileBuffer buffer;
    node.IfThere("persistent", [&](const Node& flag) { buffer.isPersistent = flag.Bool(); });
    node.IfThere("file", [&](const Node& file) { buffer.file = file.File(); });
    node.IfThere("bytes", [&](const Node& bytes) {
        if (!buffer.file.empty()) bytes.Fail("the file has the size");
        buffer.bytes = bytes.Integer(4, kMaxResourceBytes);
        if (buffer.bytes % 4 != 0) bytes.Fail("a multiple of 4 is expected");
    });
    if (buffer.bytes == 0 && buffer.file.empty()) node.Fail("it has neither bytes nor a file");
    m_graph.buffers.emplace(name, std::move(buffer));
}

// A size may be that of a texture whose own size is that of another one.
void Reader::CheckSizes(const Node& textures) const {
    textures.ForEachMember([&](const std::string& name, const Node& node) {
        std::set<std::string> seen{name};
        for (std::string other = m_graph.textures.at(name).sizeOf; !other.empty();) {
            const auto found = m_graph.textures.find(other);
            if (found == m_graph.textures.end())
                node.Find("size")->Fail("there is no texture " + Quoted(other));
            if (!seen.insert(other).second) node.Find("size")->Fail("it depends on itself");
            other = found->second.sizeOf;
        }
    });
}

void Reader::ReadPass(const Node& node) {
    node.AllowKeys({"name", "shader", "bind", "targets", "push", "specialize", "dispatch", "queue"});
    FilePass pass;
    ReadShader(pass, node);
    pass.name = NameOf(pass, node);
    node.IfThere("bind", [&](const Node& all) {
        all.ForEachMember(
            [&](const std::string& name, const Node& item) { pass.bind[name] = ResourceOf(item); });
    });
    node.IfThere("push", [&](const Node& all) {
        all.ForEachMember([&](const std::string& name, const Node& item) {
            if (item.Value() == "frame") {
                pass.push[name] = FrameNumber{};
                return;
            }
            std::vector<double> numbers;
            if (item.Value().is_array())
                item.ForEachItem([&](const Node& number) { numbers.push_back(number.Number()); });
            else if (item.Value().is_primitive() && !item.Value().is_string())
                numbers.push_back(item.Number());
            else
                item.Fail("a number, a list of numbers or \"frame\" is expected");
            pass.push[name] = std::move(numbers);
        });
    });
    node.IfThere("specialize", [&](const Node& all) {
        all.ForEachMember(
            [&](const std::string& name, const Node& item) { pass.specialize[name] = item.Number(); });
    });
    m_graph.passes.push_back(std::move(pass));
}

// Reads the shader and what only one of its kinds has.
void Reader::ReadShader(FilePass& pass, const Node& node) const {
    const std::optional<Node> shader = node.Find("shader");
    if (!shader) node.Fail("it has no shader");
    pass.shader = shader->File();
    const bool isFragment = pass.shader.extension() == ".frag";
    if (!isFragment && pass.shader.extension() != ".comp")
        shader->Fail("a .comp or a .frag file is expected");
    node.IfThere("targets", [&](const Node& all) {
        if (!isFragment) all.Fail("only a .frag has targets");
        all.ForEachItem([&](const Node& item) { pass.targets.push_back(TextureOf(item)); });
    });
    if (isFragment && pass.targets.empty()) node.Fail("a .frag needs targets");
    node.IfThere("dispatch", [&](const Node& dispatch) {
        if (isFragment) dispatch.Fail("a .frag is drawn over its targets");
        if (dispatch.Value().is_string()) {
            pass.over = TextureOf(dispatch);
            return;
        }
        std::vector<uint32_t> groups;
        dispatch.ForEachItem([&](const Node& count) { groups.push_back(count.Count(kMaxGroups)); });
        if (groups.size() != 3) dispatch.Fail("the name of a texture or three numbers are expected");
        pass.groups = {groups[0], groups[1], groups[2]};
    });
    node.IfThere("queue", [&](const Node& queue) {
        const std::string text = queue.String();
        if (text != "main" && text != "compute") queue.Fail("\"main\" or \"compute\" is expected");
        pass.isAsync = text == "compute";
        if (isFragment && pass.isAsync) queue.Fail("a .frag is drawn on the main queue");
    });
}

// Returns the name that is given, else that of the shader with a number if a pass before has it.
std::string Reader::NameOf(const FilePass& pass, const Node& node) const {
    const auto isTaken = [&](const std::string& name) {
        return std::ranges::find(m_graph.passes, name, &FilePass::name) != m_graph.passes.end();
    };
    if (const std::optional<Node> given = node.Find("name")) {
        const std::string name = given->String();
        if (isTaken(name)) given->Fail("there is a pass of that name");
        return name;
    }
    const std::string stem = pass.shader.stem().string();
    std::string name = stem;
    for (size_t i = 2; isTaken(name); ++i) name = Text("{} {}", stem, i);
    return name;
}

void Reader::ReadOutput(const std::string& file, const Node& node) {
    FileOutput output{.file = file, .resource = {}};
    const std::string extension = LowerExtension(file);
    if (extension != ".png" && extension != ".exr" && extension != ".bin")
        node.Fail("a .png, .exr or .bin file is expected");
    if (std::filesystem::path(file).filename() != file || file.find('\0') != std::string::npos)
        node.Fail("a file without a folder is expected");
    const auto setResource = [&](const Node& given) {
        output.resource = ResourceOf(given);
        if (extension != ".bin" && !m_graph.textures.contains(output.resource))
            given.Fail("a buffer is written to a .bin");
    };
    if (!node.Value().is_object()) {
        setResource(node);
    } else {
        node.AllowKeys({"texture", "layer"});
        if (extension == ".bin") node.Fail("a .bin has all layers of a texture, which is given by its name");
        if (!node.Find("texture")) node.Fail("it has no texture");
        setResource(*node.Find("texture"));
        const uint32_t layers = m_graph.textures.at(output.resource).layers;
        node.IfThere("layer", [&](const Node& layer) {
            output.layer = static_cast<uint32_t>(layer.Integer(0, layers - 1));
        });
    }
    m_graph.outputs.push_back(std::move(output));
}

// Refuses while the text is parsed what the library would accept: deep nesting, many items, repeated keys.
class StrictParse {
  public:
    using Event = GraphJson::parse_event_t;

    explicit StrictParse(std::string_view file) : m_file(file) {}

    bool operator()(Event event, const GraphJson& value) {
        switch (event) {
            case Event::object_start:
            case Event::array_start:
                if (m_levels.size() == kMaxDepth) Fail(Text("it is nested more than {} deep", kMaxDepth));
                m_levels.push_back(
                    {.isList = event == Event::array_start, .count = 0, .key = {}, .keys = {}});
                break;
            case Event::key: {
                Level& level = m_levels.back();
                level.key = value.get<std::string>();
                if (!level.keys.insert(level.key).second) Fail("the key is there twice");
                CountItem(level);
                break;
            }
            case Event::object_end:
            case Event::array_end:
                m_levels.pop_back();
                EndItem();
                break;
            case Event::value:
                EndItem();
                break;
        }
        return true;
    }

  private:
    struct Level {
        bool isList = false;
        size_t count = 0;  // items so far
        std::string key;
        std::set<std::string> keys;
    };

    void EndItem() {
        if (!m_levels.empty() && m_levels.back().isList) CountItem(m_levels.back());
    }
    void CountItem(Level& level) const {
        if (level.count++ == kMaxItems) Fail(Text("there are more than {} items", kMaxItems));
    }
    [[noreturn]] void Fail(std::string_view why) const {
        std::string path;
        for (const Level& level : m_levels)
            path += level.isList ? Text("[{}]", level.count) : (path.empty() ? "" : ".") + level.key;
        FailAt(m_file, path, why);
    }

    std::string_view m_file;
    std::vector<Level> m_levels;
};

GraphJson ParseJson(std::string_view text, std::string_view file) {
    StrictParse strict(file);
    try {
        return GraphJson::parse(text, [&](int, GraphJson::parse_event_t event, GraphJson& value) {
            return strict(event, value);
        });
    } catch (const GraphJson::parse_error& error) {
        const size_t before = std::min(error.byte, text.size());
        const auto line = 1 + std::ranges::count(text.substr(0, before), '\n');
        FailAt(file, Text("line {}", line), "it is no JSON");
    } catch (const GraphJson::exception&) {
        FailAt(file, "", "it has a number beyond the range of numbers");
    }
}

}  // namespace

uint64_t TextureBytes(rhi::Format format, rhi::Extent2D size, uint32_t layers) {
    return rhi::ImageBytes(format, size) * layers;
}

GraphFile ParseGraphFile(std::string_view text, std::string_view name) {
    GraphFile graph;
    graph.name = name;
    const GraphJson json = ParseJson(text, name);
    Reader(graph).Read(Node(json, "", name));
    return graph;
}

GraphFile ReadGraphFile(const std::filesystem::path& path) {
    std::vector<std::byte> bytes;
    try {
        bytes = ReadFile(path, kMaxFileBytes);
    } catch (const Error& error) {
        if (error.Kind() != ErrorKind::Io) throw;
        throw Error(ErrorKind::BadInput, error.what());
    }
    GraphFile graph =
        ParseGraphFile({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string());
    graph.folder = path.parent_path();
    return graph;
}

}  // namespace raygraph::graph_run
