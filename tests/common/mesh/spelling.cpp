#include "tests/common/mesh/spelling.h"

#include <cctype>
#include <cstdio>

namespace haptics::fixture {

bool Spelling::has(const std::string& transformation) {
  if (!oneIn(3)) return false;
  made_ += transformation + ' ';
  return true;
}

void Spelling::begin() {
  lineEnd = has("line-ends") ? oneOf<std::string>({"\r\n", "\r"}) : "\n";
  spellsNumbers = has("numbers");
  hasBlanks = has("blanks");
  hasAnyCase = has("case");
}

std::string Spelling::number(double value) {
  char text[64];
  const char* const form =
      spellsNumbers ? oneOf({"%.17g", "%+.17g", "%.9e", "%.17E", "%.10f", "%014.8f", "%#.10g"}) : "%.9g";
  std::snprintf(text, sizeof text, form, value);
  std::string word = text;
  if (spellsNumbers && word.starts_with("0.") && word.size() > 2 && oneIn(2)) word.erase(0, 1);
  return word;
}

std::string Spelling::blank() { return hasBlanks ? oneOf<std::string>({" ", "\t", "  ", " \t", "\v", "\f "}) : " "; }

std::string Spelling::inAnyCase(std::string word) {
  if (!hasAnyCase) return word;
  const int way = upTo(2);
  for (std::size_t i = 0; i < word.size(); ++i) {
    const bool isUpper = way == 0 || (way == 1 && i == 0) || (way == 2 && oneIn(2));
    if (isUpper) word[i] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[i])));
  }
  return word;
}

std::string Spelling::comment() {
  return oneOf<std::string>({"#", "# by hand", "#c", "# v 1 2 3", "# C:\\models\\", "# Ger\xe4t f\xc3\xbcr 3",
                             "#f 1 2 3 \\", "# solid facet endsolid", "#3 0 1 2", "# OFF 1 1 1", "##"});
}

std::string Spelling::wrapped(std::string text) {
  if (has("no-last-end")) {
    while (text.ends_with('\n') || text.ends_with('\r')) text.pop_back();
  }
  if (has("padding"))
    text += oneOf<std::string>({"\x1a", std::string(100, '\0'), "\x1a" + std::string(7, '\0'), "\n\n\x1a\x1a"});
  return has("mark") ? "\xef\xbb\xbf" + text : text;
}

const std::vector<Vec3>& PlainSolid::vertices() {
  static const std::vector<Vec3> all = [] {
    std::vector<Vec3> points;
    for (const double z : {-0.75, 20.0}) {
      for (const auto& [x, y] :
           {std::pair{0.5, 0.0}, {40.015625, 0.0}, {40.0, 10.0}, {15.25, 10.0}, {15.0, 30.0}, {0.0, 30.0}}) {
        points.emplace_back(x, y, z);
      }
    }
    return points;
  }();
  return all;
}

const std::vector<std::array<std::uint32_t, 4>>& PlainSolid::faces() {
  static const std::vector<std::array<std::uint32_t, 4>> all = [] {
    std::vector<std::array<std::uint32_t, 4>> quads{{3, 2, 1, 0}, {5, 4, 3, 0}, {6, 7, 8, 9}, {6, 9, 10, 11}};
    for (std::uint32_t i = 0; i < 6; ++i) quads.push_back({i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6});
    return quads;
  }();
  return all;
}

TriMesh PlainSolid::mesh(bool asStrips) {
  std::vector<TriangleIndices> triangles;
  for (const auto& [a, b, c, d] : faces()) {
    triangles.push_back(asStrips ? TriangleIndices{b, c, a} : TriangleIndices{a, b, c});
    triangles.push_back({a, c, d});
  }
  return canonicalise(vertices(), triangles, {}).value().mesh;
}

namespace {

using Words = std::vector<std::string>;

std::string joined(Spelling& spelling, const Words& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : spelling.blank()) + word;
  return line;
}

/// Lines that say nothing, or are empty, at random places.
void insert(Spelling& spelling, std::vector<std::string>& lines, const std::vector<std::string>& those,
            std::size_t from = 0) {
  for (const std::string& line : those) {
    const int place = spelling.upTo(static_cast<int>(lines.size() - from));
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(from) + place, line);
  }
}

std::string text(Spelling& spelling, const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) {
    if (spelling.hasBlanks && spelling.oneIn(3)) all += spelling.blank();
    all += line;
    if (spelling.hasBlanks && spelling.oneIn(3)) all += spelling.blank();
    all += spelling.lineEnd;
  }
  return all;
}

template <class T>
void append(std::string& bytes, T value, bool isBig) {
  const auto* at = reinterpret_cast<const char*>(&value);
  std::string own(at, at + sizeof value);
  bytes += isBig ? std::string(own.rbegin(), own.rend()) : own;
}

}  // namespace

SpeltFile speltObj(Spelling& s, bool damaged) {
  s.begin();
  SpeltFile file;
  const auto& vertices = PlainSolid::vertices();
  const auto& faces = PlainSolid::faces();
  const bool continues = s.has("continuation"), comments = s.has("comments"), extras = s.has("values-of-vertices"),
             slashes = s.has("slashes"), counted = s.has("counted-back"), early = s.has("faces-first"),
             names = s.has("names"), unused = s.has("unused"), unknown = s.has("unknown-lines"), outlines = s.has("fo"),
             lines = s.has("lines");
  const auto statement = [&](const Words& words) {
    std::string line = joined(s, words);
    if (continues) {
      line.clear();
      for (const std::string& word : words) {
        if (!line.empty()) {
          line += s.oneIn(4) ? s.oneOf<std::string>({" ", ""}) + '\\' + s.oneOf<std::string>({"", " "}) + s.lineEnd +
                                   s.oneOf<std::string>({"", "  "})
                             : s.blank();
        }
        line += word;
      }
    }
    return line + (comments && s.oneIn(3) ? s.oneOf<std::string>({" ", ""}) + s.comment() : "");
  };
  std::vector<std::string> all;
  const auto putVertex = [&](std::size_t v) {
    Words words{s.inAnyCase("v")};
    for (int axis = 0; axis < 3; ++axis) words.push_back(s.number(vertices[v][axis]));
    if (damaged && v == 5) words[2] = kBadWord;
    for (int k = extras ? s.oneOf({1, 3, 4}) : 0; k > 0; --k)
      words.push_back(s.oneOf<std::string>({"1.0", "0.5", "nan", "-1.#IND", "255"}));
    all.push_back(statement(words));
    if (slashes) {
      all.push_back(statement({s.inAnyCase("vt"), "0.5", s.number(0.25)}));
      all.push_back(statement({s.inAnyCase("vn"), "0", "-2.5e-15", "nan"}));
    }
  };
  std::size_t seen = 0;
  const auto putFace = [&](std::size_t f) {
    Words words{s.inAnyCase(outlines ? "fo" : "f")};
    for (const std::uint32_t v : faces[f]) {
      const bool backwards = counted && v < seen && s.oneIn(2);
      std::string corner =
          std::to_string(backwards ? static_cast<long>(v) - static_cast<long>(seen) : static_cast<long>(v) + 1);
      if (slashes) corner += s.oneOf<std::string>({"", "/1", "//1", "/1/1"});
      words.push_back(corner);
    }
    all.push_back(statement(words));
  };
  for (std::size_t f = 0; f < faces.size();) {
    const bool mayComeNow = early || seen == vertices.size();
    if (mayComeNow && (seen == vertices.size() || s.oneIn(2))) {
      putFace(f++);
    } else {
      putVertex(seen++);
    }
  }
  while (seen < vertices.size()) putVertex(seen++);
  if (unused) all.push_back(statement({"v", s.oneOf<std::string>({"nan", "inf", "1e400", "1e60"}), "0", "-1.#IND"}));
  std::vector<std::string> more;
  if (names) {
    more = {"usemtl C:\\textures\\", "g v 1 2 3", "o f", "mtllib a b\\", "s off", "usemtl a#b", "s 1"};
  }
  if (lines) more.insert(more.end(), {"l 1 2 \\" + s.lineEnd + " 3", "p 1"});
  if (unknown) more.insert(more.end(), {"made 1999", "v1 2 3", "\\x 5"});
  file.linesSkipped = unknown ? 3 : 0;
  if (comments) more.insert(more.end(), {s.comment(), "", s.comment(), s.blank()});
  insert(s, all, more);
  file.bytes = s.wrapped(text(s, all));
  return file;
}

SpeltFile speltStl(Spelling& s, bool damaged) {
  s.begin();
  SpeltFile file;
  const auto& vertices = PlainSolid::vertices();
  const bool apart = s.has("apart"), joinedUp = s.has("joined"), named = s.has("names"), solids = s.has("solids"),
             comments = s.has("comments"), normals = s.has("normals"), unknown = s.has("unknown-lines"),
             empty = s.has("empty-lines"), broken = s.has("broken"), oneLine = s.has("one-line");
  const std::string name = !named
                               ? "part"
                               : s.oneOf<std::string>({"", "outer loop", "vertex 1 2 3", "Ger\xe4t", "solid", "part #2",
                                                       "endsolid", std::string("a\0b", 3), "facet 3", "end of facet"});
  std::vector<Words> lines;
  const auto keyword = [&](const std::string& first, const std::string& second, bool isApart) -> Words {
    if (isApart) return {s.inAnyCase(first), s.inAnyCase(second)};
    return {s.inAnyCase(first + second)};
  };
  lines.push_back({s.inAnyCase("solid"), name});
  std::size_t facets = 0;
  for (const auto& [a, b, c, d] : PlainSolid::faces()) {
    for (const auto& triangle : {std::array{a, b, c}, {a, c, d}}) {
      Words facet{s.inAnyCase("facet")};
      if (!normals || s.oneIn(2)) {
        facet.push_back(s.inAnyCase("normal"));
        for (int k = 0; k < 3; ++k)
          facet.push_back(normals ? s.oneOf<std::string>({"nan", "-1.#IND", "1,5", "1e999"}) : s.number(0));
      }
      lines.push_back(facet);
      lines.push_back(keyword("outer", "loop", !joinedUp || s.oneIn(2)));
      for (const std::uint32_t v : triangle) {
        Words words{s.inAnyCase("vertex")};
        for (int axis = 0; axis < 3; ++axis) words.push_back(s.number(vertices[v][axis]));
        if (damaged && facets == 7 && v == triangle[1]) words[3] = kBadWord;
        lines.push_back(words);
      }
      lines.push_back(keyword("end", "loop", apart && s.oneIn(2)));
      lines.push_back(keyword("end", "facet", apart && s.oneIn(2)));
      if (unknown && facets == 4) {
        lines.push_back({"colour", "1", "vertex"});
        ++file.linesSkipped;
      }
      if (solids && ++facets % 6 == 0) {
        lines.push_back(keyword("end", "solid", apart && s.oneIn(2)));
        lines.push_back({s.inAnyCase("solid"), name});
      } else if (!solids) {
        ++facets;
      }
    }
  }
  Words end = keyword("end", "solid", apart);
  if (s.oneIn(2)) end.push_back(name);
  lines.push_back(end);
  std::string all;
  // A name goes to the end of its line, unless the facet after it begins with a normal.
  const bool mayJoin = oneLine && !named && !unknown && !normals && !solids && !comments;
  for (const Words& words : lines) {
    if (empty && s.oneIn(5)) all += s.blank() + s.lineEnd;
    const bool mayBreak = broken && words.size() > 3;
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (i > 0) all += mayBreak && s.oneIn(4) ? s.lineEnd : s.blank();
      all += words[i];
    }
    if (comments && s.oneIn(4) && words.size() != 2) all += s.oneOf<std::string>({" ", ""}) + s.comment();
    all += mayJoin ? " " : s.lineEnd;
    if (comments && s.oneIn(6)) all += s.comment() + s.lineEnd;
  }
  file.bytes = s.wrapped(all);
  return file;
}

SpeltFile speltOff(Spelling& s, bool damaged) {
  s.begin();
  SpeltFile file;
  const auto& vertices = PlainSolid::vertices();
  const auto& faces = PlainSolid::faces();
  const bool keyword = s.has("keyword"), joinedUp = s.has("joined"), counts = s.has("counts"),
             comments = s.has("comments"), broken = s.has("broken"), colours = s.has("colours-of-faces"),
             unused = s.has("unused");
  bool hasDimension = false, isHomogeneous = false;
  int values = 0;
  std::string head;
  if (keyword) {
    for (const std::string prefix : {"ST", "C", "N", "4"}) {
      if (!s.oneIn(2)) continue;
      head.insert(s.oneIn(3) ? 0 : head.size(), prefix);
      values += prefix == "ST" ? 2 : prefix == "C" ? s.oneOf({3, 4}) : prefix == "N" ? 3 : 0;
      isHomogeneous = isHomogeneous || prefix == "4";
    }
    hasDimension = s.oneIn(4);
    head += hasDimension ? "nOFF" : "OFF";
    if (!hasDimension) head = s.inAnyCase(head);
    // In a keyword of both, the small n is that of nOFF.
    for (char& c : head) {
      if (c == 'n' && !hasDimension) c = 'N';
    }
    if (head == "OFF" && s.oneIn(2)) head = "";
  } else {
    head = s.inAnyCase("OFF");
    for (char& c : head) c = static_cast<char>(s.hasAnyCase ? c : std::toupper(c));
  }
  const std::size_t n = vertices.size() + (unused ? 1 : 0);
  std::vector<std::string> lines;
  std::string countsText =
      std::to_string(n) + (counts ? s.oneOf<std::string>({" ", s.lineEnd}) : " ") + std::to_string(faces.size());
  if (!counts || s.oneIn(2))
    countsText += (counts ? s.oneOf<std::string>({" ", s.lineEnd}) : " ") + (s.oneIn(2) ? "0" : "18");
  if (hasDimension) countsText = "3" + s.oneOf<std::string>({" ", s.lineEnd}) + countsText;
  if (joinedUp) {
    head += (head.empty() || s.oneIn(2) ? "" : " ") + countsText;
  } else {
    if (!head.empty()) lines.push_back(head);
    head = countsText;
  }
  lines.push_back(head);
  std::vector<Words> items;
  for (std::size_t v = 0; v < n; ++v) {
    const bool isUnused = v == vertices.size();
    const double divisor = isHomogeneous ? s.oneOf({1.0, 2.0, -0.5}) : 1;
    Words words;
    for (int axis = 0; axis < 3; ++axis) {
      words.push_back(isUnused ? s.oneOf<std::string>({"nan", "-inf", "1.#QNAN"})
                               : s.number(vertices[v][axis] * divisor));
    }
    if (damaged && v == 3) words[1] = kBadWord;
    if (isHomogeneous) words.push_back(s.number(divisor));
    for (int k = 0; k < values; ++k) words.push_back(s.oneOf<std::string>({"0", "1", "0.5", "255"}));
    items.push_back(words);
  }
  const int colour = s.oneOf({1, 3, 4});
  for (const auto& face : faces) {
    Words words{"4"};
    for (const std::uint32_t v : face) words.push_back(std::to_string(v));
    for (int k = 0; colours && k < colour; ++k)
      words.push_back(colour == 1 ? "7" : s.oneOf<std::string>({"0.5", "0.25", "1.0"}));
    items.push_back(words);
  }
  const int gap = broken ? s.oneOf({3, 8, 1'000'000}) : 0;  // a line end after one in so many words
  std::string body;
  for (const Words& words : items) {
    for (const std::string& word : words) {
      body += word;
      const bool ends = broken ? s.oneIn(gap) : &word == &words.back();
      if (ends && comments && s.oneIn(4)) body += s.oneOf<std::string>({" ", ""}) + s.comment();
      body += ends ? s.lineEnd : s.blank();
      if (ends && comments && s.oneIn(4)) body += s.comment() + s.lineEnd;
    }
  }
  std::string top;
  for (const std::string& line : lines) {
    if (comments && s.oneIn(3)) top += s.comment() + s.lineEnd;
    top += line + (comments && s.oneIn(3) ? " " + s.comment() : "") + s.lineEnd;
  }
  file.mayBeAmbiguous = broken && (counts || colours || values > 0);
  file.bytes = s.wrapped(top + body);
  return file;
}

namespace {

/// What a PLY file's header says, and its values in that order.
struct PlyParts {
  struct Property {
    std::string type, name, count;  ///< `count`: of a list.
    /// Of item i.
    std::function<std::vector<double>(std::size_t)> values;
  };
  struct Element {
    std::string name;
    std::size_t items;
    std::vector<Property> properties;
  };
  std::vector<Element> elements;
  bool areStrips = false;
};

PlyParts plyParts(Spelling& s) {
  const auto& vertices = PlainSolid::vertices();
  const auto& faces = PlainSolid::faces();
  const bool types = s.has("types"), listName = s.has("list-name"), order = s.has("faces-first"),
             more = s.has("more-properties"), elements = s.has("more-elements"), strips = s.has("strips"),
             unused = s.has("unused");
  const std::string coordinate = types ? s.oneOf<std::string>({"double", "float64", "float32", "float"}) : "float";
  PlyParts::Element vertex{"vertex", vertices.size() + (unused ? 1 : 0), {}};
  for (int axis = 0; axis < 3; ++axis) {
    vertex.properties.push_back(
        {coordinate, std::string(1, static_cast<char>('x' + axis)), "", [=, &vertices](std::size_t i) {
           return std::vector{i < vertices.size() ? vertices[i][axis] : std::nan("")};
         }});
  }
  const auto number = [](double value) { return [=](std::size_t) { return std::vector{value}; }; };
  const auto list = [](std::vector<double> values) {
    return [=](std::size_t i) { return i % 2 == 0 ? values : std::vector<double>(); };
  };
  const auto insertInto = [&](PlyParts::Element& element, const PlyParts::Property& property) {
    element.properties.insert(element.properties.begin() + s.upTo(static_cast<int>(element.properties.size())),
                              property);
  };
  const std::string count =
      types ? s.oneOf<std::string>({"uchar", "int8", "ushort", "int16", "uint32", "int"}) : "uchar";
  const std::string index =
      types ? s.oneOf<std::string>({"char", "uint8", "short", "uint16", "uint", "int32", "float", "double", "int64"})
            : "int";
  std::string name = listName
                         ? s.oneOf<std::string>({"vertex_index", "vertex_indexes", "vertexIndices", "corners", "verts"})
                         : "vertex_indices";
  // A list of another name has to be the only one of whole numbers.
  const bool isKnown = name == "vertex_indices" || name == "vertex_index";
  const std::string known = isKnown ? index : "int";
  PlyParts::Element face{strips ? "tristrips" : "face", strips ? 1 : faces.size(), {}};
  face.properties.push_back({known, name, strips ? "int" : count, [=, &faces](std::size_t i) {
                               std::vector<double> corners;
                               if (!strips) return corners.assign(faces[i].begin(), faces[i].end()), corners;
                               for (const auto& [a, b, c, d] : faces)
                                 corners.insert(corners.end(), {b * 1.0, c * 1.0, a * 1.0, d * 1.0, -1});
                               return corners;
                             }});
  if (strips) face.properties[0].type = "int";
  if (more) {
    insertInto(vertex, {"float", "quality", "", number(std::nan(""))});
    insertInto(vertex, {"uchar", "red", "", number(10)});
    insertInto(vertex, {"short", "marks", "uchar", list({1, 2})});
    insertInto(face, {"float", "texcoord", "uchar", list({0.5, 0.25, 1})});
    insertInto(face, {"int", "flags", "", number(13)});
  }
  PlyParts parts{{vertex, face}, strips};
  if (order) std::swap(parts.elements[0], parts.elements[1]);
  if (elements) {
    for (const PlyParts::Element& other :
         {PlyParts::Element{
              "camera", 1, {{"float", "view_px", "", number(0.5)}, {"uchar", "poses", "uchar", list({10, 13, 10})}}},
          {"edge", 0, {{"int", "vertex1", "", number(0)}}},
          {"material", 2, {{"uchar", "x", "", number(10)}}}}) {
      parts.elements.insert(parts.elements.begin() + s.upTo(static_cast<int>(parts.elements.size())), other);
    }
  }
  return parts;
}

std::string plyHeader(Spelling& s, const PlyParts& parts, const std::string& format, SpeltFile& file) {
  const bool comments = s.has("comments"), unknown = s.has("unknown-lines"),
             several = s.has("joined-header") && !comments && !unknown;
  std::vector<std::string> lines{joined(s, {s.inAnyCase("format"), s.inAnyCase(format), "1.0"})};
  for (const PlyParts::Element& element : parts.elements) {
    lines.push_back(joined(s, {s.inAnyCase("element"), s.inAnyCase(element.name), std::to_string(element.items)}));
    for (const PlyParts::Property& p : element.properties) {
      const std::string type = s.inAnyCase(p.type), name = s.inAnyCase(p.name);
      lines.push_back(p.count.empty() ? joined(s, {s.inAnyCase("property"), type, name})
                                      : joined(s, {s.inAnyCase("property"), s.inAnyCase("list"), s.inAnyCase(p.count),
                                                   type, name}));
    }
  }
  if (comments) insert(s, lines, {"comment by hand", "obj_info element face 3", "", "comment property", "obj_info"});
  if (unknown) insert(s, lines, {"author somebody", "made element vertex 1999"});
  file.headerLinesSkipped = unknown ? 2 : 0;
  std::string header = s.inAnyCase("ply") + s.lineEnd;
  for (const std::string& line : lines) header += line + (several && s.oneIn(2) ? " " : s.lineEnd);
  return header + s.inAnyCase("end_header") + s.lineEnd;
}

}  // namespace

SpeltFile speltPly(Spelling& s, bool damaged) {
  s.begin();
  SpeltFile file;
  const PlyParts parts = plyParts(s);
  file.areStrips = parts.areStrips;
  std::string all = plyHeader(s, parts, "ascii", file);
  const bool broken = s.has("broken"), comments = s.has("comments-in-body"),
             tooMany = !broken && s.has("too-many-words");
  for (const PlyParts::Element& element : parts.elements) {
    for (std::size_t i = 0; i < element.items; ++i) {
      Words words;
      for (const PlyParts::Property& p : element.properties) {
        const std::vector<double> values = p.values(i);
        if (!p.count.empty()) words.push_back(std::to_string(values.size()));
        const bool isWhole = p.type.find("int") != p.type.npos || p.type.find("char") != p.type.npos ||
                             p.type.find("short") != p.type.npos;
        for (const double value : values)
          words.push_back(isWhole ? std::to_string(static_cast<long>(value)) : s.number(value));
        if (damaged && element.name == "vertex" && i == 2 && p.name == "y") words.back() = kBadWord;
      }
      if (tooMany && element.name == "face" && i > 6) {
        words.push_back("nan");
        ++file.linesSkipped;
      }
      if (comments && s.oneIn(4)) all += s.oneOf<std::string>({"comment 1 2 3", "COMMENT", "obj_info x"}) + s.lineEnd;
      for (std::size_t k = 0; k < words.size(); ++k) {
        if (k > 0) all += broken && s.oneIn(4) ? s.lineEnd : s.blank();
        all += words[k];
      }
      all += broken && !comments && s.oneIn(2) ? " " : s.lineEnd;
    }
  }
  file.bytes = s.wrapped(all);
  return file;
}

SpeltFile speltBinaryPly(Spelling& s) {
  s.begin();
  s.spellsNumbers = false;
  SpeltFile file;
  const bool isBig = s.has("big-endian");
  const PlyParts parts = plyParts(s);
  file.areStrips = parts.areStrips;
  std::string all = plyHeader(s, parts, isBig ? "binary_big_endian" : "binary_little_endian", file);
  const auto put = [&](const std::string& type, double value) {
    const auto is = [&](const char* a, const char* b) { return type == a || type == b; };
    if (is("char", "int8")) return append(all, static_cast<std::int8_t>(value), isBig);
    if (is("uchar", "uint8")) return append(all, static_cast<std::uint8_t>(value), isBig);
    if (is("short", "int16")) return append(all, static_cast<std::int16_t>(value), isBig);
    if (is("ushort", "uint16")) return append(all, static_cast<std::uint16_t>(value), isBig);
    if (is("int", "int32")) return append(all, static_cast<std::int32_t>(value), isBig);
    if (is("uint", "uint32")) return append(all, static_cast<std::uint32_t>(value), isBig);
    if (is("long", "int64")) return append(all, static_cast<std::int64_t>(value), isBig);
    if (is("float", "float32")) return append(all, static_cast<float>(value), isBig);
    append(all, value, isBig);
  };
  for (const PlyParts::Element& element : parts.elements) {
    for (std::size_t i = 0; i < element.items; ++i) {
      for (const PlyParts::Property& p : element.properties) {
        const std::vector<double> values = p.values(i);
        if (!p.count.empty()) put(p.count, static_cast<double>(values.size()));
        for (const double value : values) put(p.type, value);
      }
    }
  }
  file.bytes = (s.has("mark") ? "\xef\xbb\xbf" : "") + all + (s.has("trailer") ? std::string(9, 'x') : "");
  return file;
}

SpeltFile speltBinaryStl(Spelling& s) {
  SpeltFile file;
  std::string header =
      s.has("header")
          ? s.oneOf<std::string>({"solid made by cad", "solid\nfacet normal 0 0 1\nouter loop", "COLOR=\xff\x80\1\2",
                                  "\xef\xbb\xbfsolid", "\xff\xfes\0o", "OFF", std::string(80, ' ')})
          : "binary";
  header.resize(80, s.has("fill") ? ' ' : '\0');
  std::uint32_t count = 0;
  std::string triangles;
  const bool attributes = s.has("attributes"), normals = s.has("normals");
  for (const auto& [a, b, c, d] : PlainSolid::faces()) {
    for (const auto& triangle : {std::array{a, b, c}, {a, c, d}}) {
      for (int k = 0; k < 3; ++k) append(triangles, normals ? std::nanf("") : 0.0F, false);
      for (const std::uint32_t v : triangle) {
        for (int axis = 0; axis < 3; ++axis)
          append(triangles, static_cast<float>(PlainSolid::vertices()[v][axis]), false);
      }
      append(triangles, static_cast<std::uint16_t>(attributes ? s.upTo(65535) : 0), false);
      ++count;
    }
  }
  append(header, count, false);
  file.bytes = header + triangles + (s.has("trailer") ? std::string(static_cast<std::size_t>(s.upTo(120)), 'n') : "");
  return file;
}

}  // namespace haptics::fixture
