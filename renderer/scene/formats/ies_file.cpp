#include "renderer/scene/formats/ies_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

constexpr size_t kMaxAngles = 10'000;  // in each direction of the web: steps of a fiftieth of a degree
constexpr double kMaxCandela = 1e30;   // with all factors: products with colors and areas stay finite
constexpr double kSameAngle = 1e-3;    // in degrees
constexpr double kMinStep = 1e-4;      // Degrees; less vanishes in floats.

bool IsBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v' || c == '\0';
}

std::string_view Trimmed(std::string_view text) {
    while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
    while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
    return text;
}

// Reads lines, then numbers, which stand between blanks, commas and ends of lines.
class IesReader {
  public:
    explicit IesReader(std::string_view text) : m_rest(text) {
        if (m_rest.starts_with("\xef\xbb\xbf")) m_rest.remove_prefix(3);
    }

    bool IsAtEnd() const { return m_rest.empty(); }

    std::string_view Line() {
        const size_t end = std::min(m_rest.find_first_of("\r\n"), m_rest.size());
        const std::string_view line = m_rest.substr(0, end);
        m_rest.remove_prefix(end);
        if (m_rest.starts_with("\r\n"))
            m_rest.remove_prefix(2);
        else if (!m_rest.empty())
            m_rest.remove_prefix(1);
        ++m_line;
        return line;
    }

    // `what` is for messages.
    double Number(const char* what) {
        SkipSeparators();
        if (m_rest.empty()) Fail(Text("ends where {} should be", what));
        size_t length = 0;
        while (length < m_rest.size() && !IsSeparator(m_rest[length])) ++length;
        const std::string_view word = m_rest.substr(0, length);
        std::string_view digits = word;
        if (digits.starts_with('+')) digits.remove_prefix(1);
        double number = 0.0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
        if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(number))
            Fail(Text("{} is {}, must be a number", what, Quoted(word, 40)));
        m_rest.remove_prefix(length);
        return number;
    }

    size_t Count(const char* what, size_t min) {
        const double number = Number(what);
        if (!(number >= static_cast<double>(min) && number <= double{kMaxAngles}) ||
            number != std::floor(number))
            Fail(Text("{} is {:.6g}, must be a whole number of {} to {}", what, number, min, kMaxAngles));
        return static_cast<size_t>(number);
    }

    void Skip(size_t count, const char* what) {
        for (size_t i = 0; i < count; ++i) Number(what);
    }

    [[noreturn]] void Fail(const std::string& what) const {
        throw MakeError(ErrorKind::BadInput, "line {}: {}", m_line, what);
    }

    // The line of what is read next; those of Line() are behind.
    void CountLine() { ++m_line; }

  private:
    static bool IsSeparator(char c) { return IsBlank(c) || c == ',' || c == ';'; }

    void SkipSeparators() {
        while (!m_rest.empty() && IsSeparator(m_rest.front())) {
            const char c = m_rest.front();
            m_rest.remove_prefix(1);
            if (c == '\n' || (c == '\r' && !m_rest.starts_with('\n'))) ++m_line;
        }
    }

    std::string_view m_rest;
    size_t m_line = 0;
};

// Returns whether the line is "TILT=", and sets `value` to the text after it.
bool IsTilt(std::string_view line, std::string_view& value) {
    line = Trimmed(line);
    if (!line.starts_with("TILT")) return false;
    line = Trimmed(line.substr(4));
    if (!line.starts_with('=')) return false;
    value = Trimmed(line.substr(1));
    return true;
}

// Returns whether the file is of the format of 1986, which is not named in the file, or of 1991.
bool IsBefore1995(std::string_view firstLine) {
    const std::string_view version = Trimmed(firstLine);
    return !version.starts_with("IESNA:LM-63-") && !version.starts_with("IES:LM-63-");
}

// The angles are in degrees, as in the file.
struct Web {
    PhotometricType type = PhotometricType::C;
    std::vector<double> vertical, horizontal;
    std::vector<std::vector<float>> planes;  // by horizontal angle
};

std::vector<double> ReadAngles(IesReader& reader, size_t count, const char* what, double min, double max) {
    std::vector<double> angles;
    for (size_t i = 0; i < count; ++i) {
        double angle = reader.Number(what);
        if (angle < min - kSameAngle || angle > max + kSameAngle)
            reader.Fail(Text("{} {} is {:.6g}, must be {} to {} degrees", what, i, angle, min, max));
        angle = std::clamp(angle, min, max);
        if (i > 0 && !(angle >= angles.back() + kMinStep))
            reader.Fail(
                Text("{} {} is {:.6g}, must be above {:.6g}, the one before", what, i, angle, angles.back()));
        angles.push_back(angle);
    }
    return angles;
}

bool IsSame(double a, double b) {
    return std::abs(a - b) <= kSameAngle;
}

// Adds the mirror images of all planes but that of the last angle, on the other side of it.
void MirrorAtEnd(Web& web) {
    const double end = web.horizontal.back();
    for (size_t i = web.horizontal.size() - 1; i-- > 0;) {
        web.horizontal.push_back(2.0 * end - web.horizontal[i]);
        web.planes.push_back(web.planes[i]);
    }
}

// Completes the web to all directions from a part that stands for the rest.
void CompleteC(Web& web, const IesReader& reader) {
    const double first = web.horizontal.front(), last = web.horizontal.back();
    if (web.horizontal.size() == 1) return;
    if (IsSame(first, 0.0) && IsSame(last, 90.0)) {
        MirrorAtEnd(web);  // at the plane of 90 degrees
        MirrorAtEnd(web);  // and that of 180
    } else if ((IsSame(first, 0.0) && IsSame(last, 180.0)) || (IsSame(first, 90.0) && IsSame(last, 270.0))) {
        MirrorAtEnd(web);
    } else if (IsSame(first, 0.0) && last > 180.0 && !IsSame(last, 360.0)) {
        web.horizontal.push_back(360.0);
        web.planes.push_back(web.planes.front());
    } else if (!IsSame(first, 0.0) || !IsSame(last, 360.0)) {
        reader.Fail(
            Text("horizontal angles are {:.6g} to {:.6g}, must be 0, 0 to 90, 0 to 180, 90 to 270, or all "
                 "around from 0",
                 first, last));
    }
    web.horizontal.back() = web.horizontal.front() + 360.0;
}

// A web from 0 on is a half that stands for the other one, mirrored at the vertical plane.
void CompleteAB(Web& web) {
    if (!IsSame(web.horizontal.front(), 0.0)) return;
    web.horizontal.front() = 0.0;
    const std::vector<double> half = web.horizontal;
    const std::vector<std::vector<float>> planes = web.planes;
    web.horizontal.clear();
    web.planes.clear();
    for (size_t i = half.size(); i-- > 1;) {
        web.horizontal.push_back(-half[i]);
        web.planes.push_back(planes[i]);
    }
    web.horizontal.insert(web.horizontal.end(), half.begin(), half.end());
    web.planes.insert(web.planes.end(), planes.begin(), planes.end());
}

std::vector<float> Radians(const std::vector<double>& degrees) {
    std::vector<float> radians;
    for (const double angle : degrees)
        radians.push_back(static_cast<float>(angle * std::numbers::pi / 180.0));
    return radians;
}

LightProfile ProfileOf(const Web& web) {
    LightProfile profile;
    profile.type = web.type;
    profile.vertical = Radians(web.vertical);
    profile.horizontal = Radians(web.horizontal);
    for (const std::vector<float>& plane : web.planes)
        profile.candela.insert(profile.candela.end(), plane.begin(), plane.end());
    return profile;
}

void SkipHeader(IesReader& reader, bool& isOldFormat) {
    std::string_view line, tilt;
    for (bool isFirst = true; !IsTilt(line, tilt); isFirst = false) {
        if (reader.IsAtEnd()) reader.Fail("there is no line with TILT=");
        line = reader.Line();
        if (isFirst) isOldFormat = IsBefore1995(line);
    }
    reader.CountLine();
    if (!tilt.starts_with("INCLUDE")) return;
    reader.Number("the lamp's geometry");
    reader.Skip(2 * reader.Count("the number of tilt angles", 0), "a tilt angle or factor");
}

PhotometricType ReadType(IesReader& reader) {
    const double number = reader.Number("the photometric type");
    if (number == 1.0) return PhotometricType::C;
    if (number == 2.0) return PhotometricType::B;
    if (number == 3.0) return PhotometricType::A;
    reader.Fail(Text("the photometric type is {:.6g}, must be 1, 2 or 3", number));
}

double ReadFactor(IesReader& reader, const char* what) {
    const double factor = reader.Number(what);
    if (factor < 0.0) reader.Fail(Text("{} is {:.6g}, must not be negative", what, factor));
    return factor;
}

}  // namespace

IesFile ParseIes(std::string_view text) {
    IesReader reader(text);
    bool isOldFormat = false;
    SkipHeader(reader, isOldFormat);
    reader.Skip(2, "the number of lamps or their lumens");
    double factor = ReadFactor(reader, "the candela multiplier");
    const size_t verticalCount = reader.Count("the number of vertical angles", 2);
    const size_t horizontalCount = reader.Count("the number of horizontal angles", 1);
    Web web;
    web.type = ReadType(reader);
    reader.Skip(4, "the luminaire's unit or size");
    factor *= ReadFactor(reader, "the ballast factor");
    const double ballastLamp = reader.Number("the number after the ballast factor");
    if (isOldFormat) factor *= std::max(ballastLamp, 0.0);
    reader.Number("the input watts");

    const bool isTypeC = web.type == PhotometricType::C;
    web.vertical =
        ReadAngles(reader, verticalCount, "vertical angle", isTypeC ? 0.0 : -90.0, isTypeC ? 180.0 : 90.0);
    const double side = web.type == PhotometricType::B ? 90.0 : 180.0;
    web.horizontal = ReadAngles(reader, horizontalCount, "horizontal angle", isTypeC ? 0.0 : -side,
                                isTypeC ? 360.0 : side);
    if (!isTypeC && horizontalCount == 1)
        reader.Fail("there is one horizontal angle; types A and B need two or more");

    size_t negativeCount = 0;
    for (size_t h = 0; h < horizontalCount; ++h) {
        std::vector<float>& plane = web.planes.emplace_back();
        for (size_t v = 0; v < verticalCount; ++v) {
            const double candela = reader.Number("a candela value") * factor;
            if (!(std::abs(candela) <= kMaxCandela))
                reader.Fail(Text("a candela value is {:.6g} with its factors, must be at most {:.0e}",
                                 candela, kMaxCandela));
            negativeCount += candela < 0.0 ? 1 : 0;
            plane.push_back(static_cast<float>(std::max(candela, 0.0)));
        }
    }
    isTypeC ? CompleteC(web, reader) : CompleteAB(web);
    IesFile file{.profile = ProfileOf(web), .warnings = {}};
    if (negativeCount > 0)
        file.warnings.push_back(Text("{} negative, taken as 0",
                                     Counted(negativeCount, "candela value is", "candela values are")));
    return file;
}

}  // namespace raygraph::scene
