// The map is drawn: each texel of the cube is a polygon in the plane of azimuth and height (z = cos of the
// polar angle), where areas are solid angles (Lambert's cylindrical equal-area projection), and its coverage
// of the map's cells is exact. Edges of neighbors have the same points, so the polygons leave no gaps, and a
// constant cube becomes a constant map. The map is drawn in bands, a band from the tiles that reach into it.
#include "renderer/scene/formats/cube_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <future>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

namespace raygraph::scene {
namespace {

using glm::dvec3;

constexpr uint32_t kMinHeight = 128;   // Interpolation between the map's rows keeps its moments to 1e-4.
constexpr uint32_t kMaxHeight = 4096;  // 512 MiB
constexpr uint32_t kMaxDrawnSize = kMaxHeight / 2;  // of a face: the finest that the largest map can show
constexpr size_t kBandBytes = size_t{16} << 20;
constexpr uint32_t kTileSize = 32;  // Texels a side. Those of the largest face are half as high as a band.

// Describes a point of the plane.
struct Spot {
    double x = 0.0;  // columns of the map, from its seam at -x
    double z = 0.0;  // from 1, the zenith, to -1
    bool isPole = false;
};

// Returns a point of a face, s to the right and t down, both in [-1, 1]; not of unit length.
dvec3 FacePoint(size_t face, double s, double t) {
    switch (face) {
        case 0:
            return {1.0, -t, s};
        case 1:
            return {-1.0, -t, -s};
        case 2:
            return {-s, 1.0, t};
        case 3:
            return {-s, -1.0, -t};
        case 4:
            return {-s, -t, 1.0};
        default:
            return {s, -t, -1.0};
    }
}

// Sums over the cells of some rows of the map. An edge that leads up adds what lies to its right, and one
// that leads down takes it away, so a clockwise polygon adds what is inside; the running sum along a row is
// the integral over each cell (as in font rasterizers).
class Band {
  public:
    Band(uint32_t width, uint32_t height, uint32_t firstRow, uint32_t rowCount)
        : m_width(width), m_firstRow(firstRow), m_sums((size_t{width} + 2) * rowCount) {
        for (uint32_t row = firstRow; row <= firstRow + rowCount; ++row)
            m_edges.push_back(row == 0        ? 1.0
                              : row == height ? -1.0
                                              : std::cos(glm::pi<double>() * row / height));
    }

    double Top() const { return m_edges.front(); }
    double Bottom() const { return m_edges.back(); }

    // Columns of both ends are in [0, width].
    void AddEdge(Spot from, Spot to, dvec3 radiance) {
        if (from.z == to.z) return;
        if (from.z < to.z)
            std::swap(from, to);
        else
            radiance = -radiance;
        if (from.z <= Bottom() || to.z >= Top()) return;
        const double slope = (to.x - from.x) / (to.z - from.z);
        const auto at = [&](double z) { return from.x + (z - from.z) * slope; };
        const auto above = std::upper_bound(m_edges.begin(), m_edges.end(), from.z, std::greater<>());
        size_t row = above == m_edges.begin() ? 0 : static_cast<size_t>(above - m_edges.begin()) - 1;
        for (; row + 1 < m_edges.size() && m_edges[row] > to.z; ++row) {
            const double high = std::min(m_edges[row], from.z), low = std::max(m_edges[row + 1], to.z);
            if (high > low) AddInRow(row, at(high), at(low), (high - low) * radiance);
        }
    }

    // Stores the mean radiance of the cells in the map's rows.
    void Store(image::ImageF& map) const {
        for (size_t row = 0; row + 1 < m_edges.size(); ++row) {
            const double scale = 1.0 / (m_edges[row] - m_edges[row + 1]);
            float* texel = &map.rgba[4 * (m_firstRow + row) * m_width];
            dvec3 sum(0.0);
            for (uint32_t column = 0; column < m_width; ++column, texel += 4) {
                sum += m_sums[row * (m_width + 2) + column];
                // Rounding may leave a little less than nothing
                for (int c = 0; c < 3; ++c) texel[c] = static_cast<float>(std::max(sum[c] * scale, 0.0));
                texel[3] = 1.0f;
            }
        }
    }

  private:
    // Adds an edge within a row; `weight` is radiance times its height.
    void AddInRow(size_t row, double x0, double x1, const dvec3& weight) {
        if (x0 > x1) std::swap(x0, x1);
        dvec3* const sums = &m_sums[row * (m_width + 2)];
        const auto columnOf = [&](double x) {
            return std::min(static_cast<uint32_t>(std::max(x, 0.0)), m_width - 1);
        };
        const uint32_t first = columnOf(x0), last = columnOf(x1);
        double left = x0;
        for (uint32_t column = first; column <= last; ++column) {
            const double right = column == last ? x1 : column + 1.0;
            const double share = first == last ? 1.0 : (right - left) / (x1 - x0);
            const double outside = 0.5 * (left + right) - column;  // of the cell, to the left of the edge
            sums[column] += share * (1.0 - outside) * weight;
            sums[column + 1] += share * outside * weight;
            left = right;
        }
    }

    uint32_t m_width, m_firstRow;
    std::vector<double> m_edges;  // heights, from the top
    std::vector<dvec3> m_sums;
};

class Drawing {
  public:
    Drawing(const CubeMap& cube, uint32_t height)
        : m_cube(cube),
          m_size(std::min(cube.faces[0]->width, kMaxDrawnSize)),
          m_width(2 * height),
          m_toWorld(glm::mat3_cast(glm::normalize(glm::dquat(cube.rotation)))) {
        for (size_t face = 0; face < 6; ++face)
            for (uint32_t top = 0; top < m_size; top += kTileSize)
                for (uint32_t left = 0; left < m_size; left += kTileSize)
                    m_tiles.push_back(TileAt(face, left, top));
    }

    // Returns how many texels it took to draw the band.
    uint64_t Draw(Band& band) const {
        uint64_t texels = 0;
        for (const Tile& tile : m_tiles) {
            if (tile.lowest >= band.Top() || tile.highest <= band.Bottom()) continue;
            DrawTile(band, tile);
            texels += uint64_t{tile.width} * tile.height;
        }
        return texels;
    }

  private:
    using Polygon = std::vector<Spot>;

    // Describes a part of a face; it is somewhere between these heights.
    struct Tile {
        size_t face;
        uint32_t left, top, width, height;
        double lowest, highest;
    };

    Tile TileAt(size_t face, uint32_t left, uint32_t top) const {
        Tile tile{face, left, top, std::min(kTileSize, m_size - left), std::min(kTileSize, m_size - top),
                  -1.0, 1.0};
        const auto direction = [&](double x, double y) {
            return Direction(face, left + x * tile.width, top + y * tile.height);
        };
        // The cone around its corners has all of it, and its poles
        const dvec3 center = direction(0.5, 0.5);
        double radius = 0.0;
        for (const double x : {0.0, 1.0})
            for (const double y : {0.0, 1.0})
                radius = std::max(radius, std::acos(std::min(glm::dot(center, direction(x, y)), 1.0)));
        radius += 1e-6;  // far more than rounding, far less than a row
        const double polar = std::acos(std::clamp(center.y, -1.0, 1.0));
        if (polar > radius) tile.highest = std::cos(polar - radius);
        if (polar + radius < glm::pi<double>()) tile.lowest = std::cos(polar + radius);
        return tile;
    }

    void DrawTile(Band& band, const Tile& tile) const {
        std::vector<Spot> lines[2], middles;
        lines[1] = Line(tile, tile.top, 2);
        for (uint32_t row = tile.top; row < tile.top + tile.height; ++row) {
            std::swap(lines[0], lines[1]);
            lines[1] = Line(tile, row + 1.0, 2);
            middles = Line(tile, row + 0.5, 1);
            for (uint32_t i = 0; i < tile.width; ++i) {
                const uint32_t column = tile.left + i;
                const glm::vec3 radiance =
                    m_cube.intensity * MeanRadiance(*m_cube.faces[tile.face], m_size, column, row);
                if (radiance == glm::vec3(0.0f)) continue;
                const size_t at = 2 * size_t{i};
                DrawTexel(band, tile.face, column, row,
                          {lines[0][at], lines[0][at + 1], lines[0][at + 2], middles[i + 1], lines[1][at + 2],
                           lines[1][at + 1], lines[1][at], middles[i], lines[0][at]},
                          radiance);
            }
        }
    }

    // Returns the direction of a point of a face, in texels.
    dvec3 Direction(size_t face, double column, double row) const {
        const double scale = 2.0 / m_size;
        return glm::normalize(m_toWorld * FacePoint(face, column * scale - 1.0, row * scale - 1.0));
    }
    Spot SpotAt(size_t face, double column, double row) const {
        const dvec3 d = Direction(face, column, row);
        const double turn = std::atan2(d.z, d.x) / glm::two_pi<double>() + 0.5;
        return {turn * m_width, d.y, d.x * d.x + d.z * d.z < 1e-20};
    }

    // Returns points across a tile: that many points a texel. Neighbors have the same ones where they meet.
    std::vector<Spot> Line(const Tile& tile, double row, uint32_t pointsPerTexel) const {
        std::vector<Spot> spots;
        for (uint32_t i = 0; i <= pointsPerTexel * tile.width; ++i)
            spots.push_back(SpotAt(tile.face, tile.left + static_cast<double>(i) / pointsPerTexel, row));
        return spots;
    }

    // Returns the way from x to that of a neighbor, the shorter way around.
    double WrappedDifference(double from, double to) const { return std::remainder(to - from, m_width); }

    // An outline has corners and middles of edges, around a texel.
    using Outline = std::array<Spot, 9>;

    void DrawTexel(Band& band, size_t face, uint32_t column, uint32_t row, const Outline& outline,
                   const dvec3& radiance) const {
        bool isPlain = true;  // neither at the seam nor near a pole
        for (size_t k = 0; k < 8; ++k)
            isPlain &=
                !outline[k].isPole && std::abs(outline[k].x - outline[k + 1].x) < kStraightTurn * m_width;
        if (!isPlain) {
            DrawPolygon(band, Corners(face, column, row, outline), radiance);
            return;
        }
        for (size_t k = 0; k < 8; ++k) band.AddEdge(outline[k], outline[k + 1], radiance);
    }

    // More points where an edge is seen from near a pole, since it is not straight there.
    Polygon Corners(size_t face, uint32_t column, uint32_t row, const Outline& around) const {
        constexpr double kPlaces[9][2]{{0, 0},  {.5, 0}, {1, 0},  {1, .5}, {1, 1},
                                       {.5, 1}, {0, 1},  {0, .5}, {0, 0}};
        Polygon polygon;
        for (size_t k = 0; k < 8; ++k) {
            polygon.push_back(around[k]);
            const double turn = std::abs(WrappedDifference(around[k].x, around[k + 1].x)) / m_width;
            if (turn < kStraightTurn || around[k].isPole || around[k + 1].isPole) continue;
            const int parts = std::clamp(static_cast<int>(turn * 1024.0), 2, 512);
            for (int part = 1; part < parts; ++part) {
                const double share = static_cast<double>(part) / parts;
                polygon.push_back(SpotAt(face, column + glm::mix(kPlaces[k][0], kPlaces[k + 1][0], share),
                                         row + glm::mix(kPlaces[k][1], kPlaces[k + 1][1], share)));
            }
        }
        return polygon;
    }
    static constexpr double kStraightTurn = 1.0 / 256.0;  // of a whole turn

    void DrawPolygon(Band& band, const Polygon& corners, const dvec3& radiance) const {
        const Polygon polygon = Unwrapped(corners);
        double low = polygon[0].x, high = low;
        for (const Spot& spot : polygon) {
            low = std::min(low, spot.x);
            high = std::max(high, spot.x);
        }
        // Parts beyond the seam are drawn once more from the other side
        for (double start = std::floor(low / m_width) * m_width; start < high; start += m_width)
            for (size_t i = 0; i + 1 < polygon.size(); ++i) {
                Spot from = polygon[i], to = polygon[i + 1];
                from.x -= start;
                to.x -= start;
                AddClipped(band, from, to, radiance);
            }
    }

    // Returns a closed polygon without jumps at the seam. A polygon through or around a pole has a part of
    // the pole's line.
    Polygon Unwrapped(const Polygon& corners) const {
        const size_t count = corners.size();
        size_t start = 0;
        while (start + 1 < count && corners[start].isPole) ++start;
        Polygon polygon{corners[start]};
        double x = corners[start].x;
        for (size_t k = 1; k <= count; ++k) {
            const Spot& spot = corners[(start + k) % count];
            const double pole = spot.z > 0.0 ? 1.0 : -1.0;
            if (spot.isPole) {
                polygon.push_back({x, pole});
                const Spot& next = corners[(start + k + 1) % count];
                if (!next.isPole) polygon.push_back({x += WrappedDifference(x, next.x), pole});
            } else {
                polygon.push_back({x += WrappedDifference(x, spot.x), spot.z});
            }
        }
        const double first = polygon.front().x;
        if (std::abs(x - first) > 0.5 * m_width) {
            const double pole = polygon.front().z > 0.0 ? 1.0 : -1.0;
            polygon.push_back({x, pole});
            polygon.push_back({first, pole});
            polygon.push_back(polygon.front());
        }
        polygon.back() = polygon.front();
        return polygon;
    }

    // The part of an edge beyond the left or the right end is moved onto that end's line.
    void AddClipped(Band& band, const Spot& from, const Spot& to, const dvec3& radiance) const {
        const double width = m_width;
        const auto onMap = [&](Spot spot) {
            spot.x = std::clamp(spot.x, 0.0, width);
            return spot;
        };
        double cuts[4]{0.0, 1.0, 1.0, 1.0};
        size_t count = 1;
        if (const double way = to.x - from.x; way != 0.0) {
            double enters = -from.x / way, leaves = (width - from.x) / way;
            if (enters > leaves) std::swap(enters, leaves);
            for (const double cut : {enters, leaves})
                if (cut > 0.0 && cut < 1.0) cuts[count++] = cut;
        }
        cuts[count] = 1.0;
        Spot last = from;
        for (size_t i = 1; i <= count; ++i) {
            const Spot next =
                i == count ? to : Spot{glm::mix(from.x, to.x, cuts[i]), glm::mix(from.z, to.z, cuts[i])};
            band.AddEdge(onMap(last), onMap(next), radiance);
            last = next;
        }
    }

    const CubeMap& m_cube;
    const uint32_t m_size, m_width;  // of a face as it is drawn; of the map
    const glm::dmat3 m_toWorld;
    std::vector<Tile> m_tiles;
};

// Returns the curve of IEC 61966-2-1.
std::array<float, 256> SrgbTable() {
    std::array<float, 256> table{};
    for (size_t i = 0; i < table.size(); ++i) {
        const double value = static_cast<double>(i) / 255.0;
        table[i] =
            static_cast<float>(value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4));
    }
    return table;
}

}  // namespace

glm::vec3 FaceRadiance(const uint8_t* rgba) {
    static const std::array<float, 256> kSrgb = SrgbTable();
    const float factor = 255.0f / static_cast<float>(std::max<uint8_t>(rgba[3], 1));
    return factor * glm::vec3(kSrgb[rgba[0]], kSrgb[rgba[1]], kSrgb[rgba[2]]);
}

glm::vec3 MeanRadiance(const ImageData& face, uint32_t size, uint32_t column, uint32_t row) {
    const auto at = [&](uint64_t x, uint64_t y) {
        return FaceRadiance(&face.rgba[4 * (y * face.width + x)]);
    };
    if (face.width == size) return at(column, row);
    // Holds the overlap of a texel of the smaller face with one of the larger: lengths in units of which a
    // texel of the larger face is `size` long.
    struct Part {
        double length, center;  // from -1 to 1
    };
    const auto partOf = [&](uint64_t place, uint64_t texel) {
        const auto begin = static_cast<double>(std::max(place * face.width, texel * size));
        const auto end = static_cast<double>(std::min((place + 1) * face.width, (texel + 1) * size));
        return Part{end - begin, (begin + end) / (1.0 * face.width * size) - 1.0};
    };
    const auto first = [&](uint64_t place) { return place * face.width / size; };
    const auto last = [&](uint64_t place) { return ((place + 1) * face.width - 1) / size; };
    dvec3 sum(0.0);
    double weights = 0.0;
    for (uint64_t y = first(row); y <= last(row); ++y) {
        const Part high = partOf(row, y);
        for (uint64_t x = first(column); x <= last(column); ++x) {
            const Part wide = partOf(column, x);
            const double square = 1.0 + wide.center * wide.center + high.center * high.center;
            const double solidAngle = wide.length * high.length / (square * std::sqrt(square));
            sum += solidAngle * dvec3(at(x, y));
            weights += solidAngle;
        }
    }
    return sum / weights;
}

uint32_t EquirectHeight(uint32_t faceSize) {
    return static_cast<uint32_t>(std::clamp<uint64_t>(uint64_t{2} * faceSize, kMinHeight, kMaxHeight));
}

image::ImageF ToEquirect(const CubeMap& cube, unsigned threads, uint64_t* drawnTexels) {
    const uint32_t height = EquirectHeight(cube.faces[0]->width), width = 2 * height;
    image::ImageF map{width, height, std::vector<float>(size_t{4} * width * height)};
    const uint32_t rows = std::clamp<uint32_t>(
        static_cast<uint32_t>(kBandBytes / (sizeof(dvec3) * (size_t{width} + 2))), 1, height);
    const uint32_t bandCount = (height + rows - 1) / rows;
    const Drawing drawing(cube, height);
    std::atomic<uint32_t> next = 0;
    std::atomic<uint64_t> drawn = 0;
    const auto work = [&] {
        for (uint32_t band; (band = next++) < bandCount;) {
            const uint32_t first = band * rows;
            Band part(width, height, first, std::min(rows, height - first));
            drawn += drawing.Draw(part);
            part.Store(map);
        }
    };
    std::vector<std::future<void>> others;
    for (unsigned i = 1; i < std::min(threads, bandCount); ++i)
        others.push_back(std::async(std::launch::async | std::launch::deferred, work));
    work();
    for (std::future<void>& other : others) other.get();
    if (drawnTexels) *drawnTexels = drawn;
    return map;
}

}  // namespace raygraph::scene
