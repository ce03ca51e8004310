// The rules of the command language as users read them.
#pragma once

#include <string_view>

namespace turgor::commands {

inline constexpr std::string_view kLanguage =
    R"(A script is a text of commands, one a line: a name, then values and flags.

    ; a plan
    #include patient.turgor
    osteotomy chin -of mandible -plane 0 -80 -55 0 -0.3 -1
    move chin -by 0 -5mm 0

- Blanks part words. Values without a flag stand in the order of the usage line; flags (-name, followed by their
  values) stand before, between or after them. Also --name, and -name=value.
- A word that begins with a minus and a letter is a flag; with a minus and a digit or a point, a number. After -- no
  word is a flag.
- Numbers are in the unit named in the usage line, or carry another one: mm, cm, m; deg, rad; HU; MPa, kPa, Pa; N, mN,
  kN; % of a fraction. The point is the decimal sign.
- Positions and displacements are patient coordinates (LPS) in mm: x to the patient's left, y to the back, z upwards.
- ; starts a comment anywhere outside quotes, # where a word could begin.
- 'Single quotes' keep everything as it stands. In "double quotes" \" is a quote and \\ a backslash. Outside of quotes
  a backslash keeps the next character as it stands; at the end of a line it joins the next line to it. A quote ends on
  the line on which it began.
- #include FILE at the start of a line puts the commands of that file in its place, to any depth. FILE is sought from
  the folder of the including file, then along the search paths. A file that includes itself is an error.
- Text is UTF-8.
)";

}  // namespace turgor::commands
