#pragma once

namespace abbe {

/// The drilling machine of seed 000 with its 79 errors, alignment of rotary axes after the motion as printed.
/// Test support.
inline constexpr const char* kSevenAxes = R"(format = 1
[machine]
name = "regression"
chain = "w B1 b Y X Z A B Z1 S t"
[units]
error_length = "mm"
error_angle = "rad"
[axis.A]
location = "after"
[axis.B]
location = "after"
[axis.B1]
location = "after"
origin = [0, -600.0, -1500.0]
direction = [0, 1, 0]
errors_seen = "body"
[axis.Z1]
origin = [0, -85.0, -240.0]
[axis.S]
origin = [0, -85.0, -240.0]
[tool]
origin = [0, -85.0, -240.0]
length = -150.0
[workpiece]
origin = [0, -600.0, -1500.0]
[errors]
EXY = 0.0139
EYY = -0.0184
EZY = 0.004
EAY = 9.9e-06
EBY = 2.39e-05
ECY = 1.29e-05
TXY = 0.0039
TYY = -0.0195
TZY = -0.0077
EXX = 0.0188
EYX = 0.0187
EZX = 0.0017
EAX = -7.6e-06
EBX = 1.65e-05
ECX = -1.37e-05
TXX = 0.0117
TYX = -0.0149
TZX = 0.0175
EXZ = 0.0167
EYZ = -0.017
EZZ = -0.0156
EAZ = 2.36e-05
EBZ = -2.94e-05
ECZ = 2.84e-05
TXZ = -0.0035
TYZ = 0.0051
TZZ = -0.0089
EXZ1 = -0.0026
EYZ1 = 0.0111
EZZ1 = 0.0039
EAZ1 = -1.07e-05
EBZ1 = -2.9e-05
ECZ1 = 7.5e-06
TXZ1 = 0.0165
TYZ1 = -0.0056
TZZ1 = -0.0195
EXA = 0.0149
EYA = 0.0018
EZA = -0.0044
EAA = 2.69e-05
EBA = 4e-06
ECA = 2.14e-05
TXA = -0.018
TYA = -0.0167
TZA = 0.0171
EXB = -0.0146
EYB = 0.0105
EZB = 0.012
EAB = -1.44e-05
EBB = 6.3e-06
ECB = -2.07e-05
TXB = 0.0026
TYB = -0.0058
TZB = 0.0181
EXB1 = -0.0009
EYB1 = -0.0153
EZB1 = 0.0001
EAB1 = -5e-06
EBB1 = 1.71e-05
ECB1 = 6.7e-06
TXB1 = -0.0032
TYB1 = -0.0116
TZB1 = -0.0053
TXS = 0.0089
TYS = -0.0138
TZS = 0.0037
TAS = -7.5e-06
TBS = -7.8e-06
EC0X = -2.76e-05
EB0Z = 3.3e-06
EA0Z = 2.57e-05
EB0Z1 = 2.2e-05
EA0Z1 = -3e-06
EB0A = -1.91e-05
EC0A = -1.67e-05
EA0B = -2.47e-05
EC0B = 1.77e-05
EA0B1 = 2.85e-05
EC0B1 = -2.78e-05
)";

}  // namespace abbe
