#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "abbe/chain/predict.h"
#include "abbe/machine/read_machine.h"

// Numbers computed by independent programs: with 50-digit arithmetic from the equations of seeds 000 to
// 003, and in double from the definition of the machine file for machines of random structure.

namespace abbe {
namespace {

constexpr double kExactLength = 1e-9;  // mm
constexpr double kExactAxis = 1e-12;
constexpr double kFirstOrder = 1e-10;  // mm

struct Expected {
  ErrorModel model = ErrorModel::rigid;
  Vec3 position = Vec3::Zero(), tool_axis = Vec3::Zero();  ///< actual; first order: deviation
  double length = kExactLength, axis = kExactAxis;
};

void check(const char* text, const std::map<std::string, double>& q, const Environment& environment,
           const std::map<std::string, int>& approach, const std::vector<Expected>& all) {
  const Parsed<Machine> parsed =
      read_machine({"regression.toml", text}, std::nullopt,
                   [](const std::string&) { return std::optional<std::string>(); });
  ASSERT_TRUE(parsed.value.has_value())
      << (parsed.diagnostics.empty() ? "" : to_text(parsed.diagnostics.front()));
  const Machine& machine = *parsed.value;
  Query query;
  query.tool = tool_of(machine);
  for (const auto& [name, value] : q) {
    const int i = machine.find_axis(name);
    query.q.at(static_cast<std::size_t>(i)) = value * machine.axis_unit(i);
  }
  for (const auto& [name, sign] : approach) {
    query.approach.at(static_cast<std::size_t>(machine.find_axis(name))) = static_cast<signed char>(sign);
  }
  for (const Expected& expected : all) {
    const auto made = make_plan(machine, environment, expected.model);
    ASSERT_TRUE(std::holds_alternative<Plan>(made));
    const Prediction p = predict(std::get<Plan>(made), query);
    const TipAndAxis& got = expected.model == ErrorModel::first_order ? p.deviation : p.actual;
    EXPECT_LE((got.position - expected.position).cwiseAbs().maxCoeff(), expected.length)
        << got.position.transpose();
    EXPECT_LE((got.tool_axis - expected.tool_axis).cwiseAbs().maxCoeff(), expected.axis)
        << got.tool_axis.transpose();
  }
}

TEST(Regression, RandomMachine07) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w Y C b Z U X t"
[units]
length = "mm"
angle = "deg"
error_length = "um"
error_angle = "urad"
[axis.Y]
direction = [-0.828106, -0.163656, -0.518674]
order = ["location", "motion", "-location", "static"]
errors_seen = "tool"
[axis.C]
origin = [-221.408828, 101.946578, 358.167154]
direction = [-0.206639, 0.95251, -0.906835]
location = "frame"
errors_seen = "body"
[axis.Z]
origin = [56.730952, 48.205822, 145.602156]
direction = [0.142409, -0.624258, -0.805139]
location = "line"
[axis.U]
origin = [-2.868404, 25.376197, 221.78302]
[axis.X]
origin = [-256.1866, 223.863704, -334.515991]
[tool]
origin = [91.778116, -84.824894, 192.069939]
length = 29.516445
[workpiece]
origin = [154.284558, -208.809279, -6.62214]
[errors]
EXY = { forward = -16.895180713, backward = { poly = [2.323030106, 0.02890941715] } }
EZY = [ { poly = [3.774795084, 0.007989520428] }, { sine = [-1.751786748, 0.015, 0.3] } ]
ECY = { forward = -26.100001457, backward = { poly = [13.869560078, -0.028558893523] } }
EY0Y = 16.672649047
EA0Y = -5.90134462
EB0Y = -21.784431419
EXC = { poly = [0, 0.194586832], of = "v.U" }
EYC = { poly = [0, 3.661849632], of = "T1", reference = 20 }
EZC = { table = [[-96.49553, -9.490135228], [-95.99901, -19.836255865], [-5.41342, -3.242139955], [32.08446, -5.229857084]] }
EAC = { table = [[-15.60826, 3.556304451], [55.78793, -6.115822167], [65.00704, -6.352799041], [86.32251, -1.10863091], [129.3127, -5.973442169], [133.55262, -18.563427746], [162.08062, 29.080056045], [162.67904, -3.562387901]] }
EBC = { grid = [[-23.857224136, 4.007016488, 2.197121278], [26.936925514, 6.824235779, -25.781065431], [-17.522839033, -7.426238292, 8.064574712]], at = [[-400.0, 0, 400.0], [18, 20.5, 25]], of = ["Y", "T1"] }
TZC = { poly = [0, 0.1095783826], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
TCC = { poly = [14.980435227, 0.080117074811, -3.9588993488e-05] }
EZ0C = 5.716683228
EA0C = 20.726855663
EXZ = { table = [[-243.88318, -10.424493009], [2.15762, -3.972625214], [33.2537, 12.133042582], [90.58258, -12.003280664], [109.15354, -0.288726283], [206.65794, 9.240159699], [230.71941, 19.584143468]], interpolation = "cubic" }
EYZ = { poly = [0, -0.024082563672], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EZZ = [ { poly = [-2.110892889, 0.043702120127] }, { sine = [19.521522328, 0.015, 0.3] } ]
EBZ = { table = [[-242.63507, 7.443983846], [-236.50131, 24.018500273], [-218.52334, 20.426131637]], interpolation = "cubic" }
ECZ = { forward = -9.359585881, backward = { poly = [8.587985822, 0.05019732117] } }
TXZ = { poly = [0, 2.258423073], of = "T1", reference = 20 }
TAZ = { forward = -10.048968008, backward = { poly = [18.049414134, 0.070748593347] } }
DAZ = { table = [[-283.06055, 2.919602639], [-119.67399, -22.140968879], [125.81463, -29.145423711], [245.20159, 28.253410634], [261.20838, 8.98048018], [323.88168, 1.594862826], [384.24475, 26.017488303]] }
EY0Z = -9.926607545
EZ0Z = -10.378424298
EB0Z = -4.859246835
EC0Z = 24.601023379
EXU = { poly = [0, 0.016247483032], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EZU = { poly = [0, 0.007072213872], of = "C" }
EAU = 22.368335921
EBU = { grid = [[16.562337935, -21.011850906, -21.506461736], [7.146074351, -22.779803325, -26.294682774], [10.939881884, 1.843581299, -1.050779171]], at = [[-400.0, 0, 400.0], [18, 20.5, 25]], of = ["Y", "T1"] }
ECU = { poly = [0, -0.037725851842], of = "Y" }
TXU = { poly = [0.308559672, 0.006172938665, 6.499828565e-05] }
EZ0U = 2.38055226
EC0U = -22.702682737
EXX = { poly = [6.846217883, -0.007166132277, -7.18275501e-05] }
EYX = { poly = [15.881057315, -0.034555337623, 5.40299707e-05] }
EZX = { table = [[-224.32974, -0.509569], [-81.3945, 19.59485819], [306.26627, 13.297786779], [362.0033, -13.541357605], [374.03583, -2.73912728]] }
EAX = [ { poly = [-4.723411562, -0.021507781015] }, { sine = [-24.468358432, 0.015, 0.3] } ]
EBX = [ { poly = [3.243014868, -0.00893128473] }, { sine = [-28.91508115, 0.015, 0.3] } ]
ECX = { grid = [[0.735737068, -26.142552445, 29.104994648], [17.301783366, 28.301757519, -23.713224344], [-14.066143659, -27.624708605, 16.739845804]], at = [[-400.0, 0, 400.0], [18, 20.5, 25]], of = ["Z", "T1"] }
TXX = { table = [[-328.43023, -17.698939502], [-280.50564, 7.528222854], [-193.11279, -2.987318368], [-62.19665, -17.103436211], [56.47594, 17.533988362], [160.33396, 5.377580252], [255.18318, 12.065143663], [329.13105, -16.650298951], [335.33721, 14.249145455]] }
TYX = { poly = [-1.849059161, -0.016084822273, 1.3266029612e-05] }
TAX = { table = [[-312.43883, -20.313054504], [-209.25106, -26.977216967], [21.53202, -17.893905074]] }
DCX = { sine = [-27.783038907, 0.008862943, 0.033924] }
EZ0X = -2.117778031
EAt = -17.089132823
EBt = -18.082531021
EYw = 19.577522679
EBw = 7.526898864
)";
  check(kText, {{"Y", -47.37336}, {"C", -136.04727}, {"Z", 113.01573}, {"U", -81.47686}, {"X", 4.06495}},
        {{"T1", 25.74}, {"v.Z", -50.344}, {"v.U", -79.42}, {"v.X", -27.372}},
        {{"Y", 1}, {"C", 0}, {"Z", -1}, {"U", -1}, {"X", 0}},
        {{ErrorModel::rigid, Vec3(-850.530323278254, 302.49483751345474, 480.2394234245269),
          Vec3(0.6784441573216353, -0.7304923029101524, 0.07806741180005096)},
         {ErrorModel::linear, Vec3(-850.5303233137836, 302.49483741604104, 480.2394236083055),
          Vec3(0.6784441587242047, -0.7304923045997043, 0.07806741217621666)},
         {ErrorModel::first_order, Vec3(0.01627668432522948, -0.06493740000661319, 0.02124161679654435),
          Vec3(8.346429489158869e-06, 2.327035489006294e-06, -5.072611625400736e-05), kFirstOrder}});
}

TEST(Regression, RandomMachine13) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w B1 b Z X C Y t"
[units]
length = "mm"
angle = "deg"
error_length = "um"
error_angle = "urad"
[axis.B1]
origin = [-228.873976, -164.274597, -54.735737]
direction = [0.216804, -0.971135, -0.448326]
location = "frame"
errors_seen = "tool"
[axis.Z]
[axis.X]
location = "after"
[axis.C]
origin = [318.592642, 39.762149, 385.137251]
[axis.Y]
origin = [-123.216612, 75.740134, 107.027799]
direction = [-0.103245, 0.222378, 0.974309]
[tool]
origin = [-22.640018, -129.346501, -118.949347]
length = 130.673325
axis = [-0.0811, 0.211, 1.0]
[workpiece]
origin = [-62.545579, -221.531423, -5.485718]
[errors]
EXB1 = { table = [[-132.80351, -1.45386416], [-25.0629, -19.912759149], [46.47094, -3.027386089], [72.5567, 14.70016451]], interpolation = "cubic" }
EYB1 = { poly = [0, 0.068021172778], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EAB1 = { table = [[-106.89901, -21.779549762], [-45.08775, 28.278197365], [-31.14327, 6.210000174], [77.94399, 13.362858964], [109.14196, -17.297058614], [127.31552, 7.034429778], [132.56695, 4.852473155], [139.02927, 5.473499017]] }
EBB1 = { poly = [0, -0.095199666], of = "v.Y" }
ECB1 = { table = [[-166.0221, -9.416456828], [-155.10819, -24.440284285], [-139.58634, -29.821527544], [-98.79933, 29.874826362], [-21.74738, -22.709028389], [15.59361, -11.909813178], [20.21508, -13.863340811], [51.66965, 5.835534498], [66.25126, -25.354363052]] }
TAB1 = [ { poly = [-20.696190076, 0.019920103178] }, { sine = [1.96600803, 0.033333333, 0.3] } ]
TCB1 = { table = [[-127.30787, -4.478343717], [-123.45192, 19.451460175], [-44.57961, -17.089709822], [77.12056, -4.50891692], [107.57107, -15.853961994]], interpolation = "cubic" }
EY0B1 = -18.175667644
EB0B1 = -3.029714459
EXZ = -8.422576032
EYZ = { table = [[-310.45241, -7.865868627], [-225.38004, -4.466271612], [258.80314, -18.665012018], [290.8519, -14.869048864]] }
EZZ = { poly = [0, 0.008523689862], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EAZ = { poly = [0, -5.477094112], of = "T1", reference = 20 }
EBZ = { table = [[-360.66124, 25.912701654], [-328.25279, -25.777965928], [-266.68834, -14.155954509], [145.26953, 19.291102237], [191.72649, -27.182956464], [309.76062, -15.731962025], [315.62871, 19.673489899], [321.86999, -15.676764464], [329.8809, 17.171396131]] }
ECZ = { table = [[-358.44304, -7.755118519], [-356.62063, -6.20700346], [-85.53159, -21.059711444], [37.68753, 2.728466078], [90.65674, -14.35387235], [207.99497, -7.639419413], [354.06218, 25.902705802]], interpolation = "cubic" }
TXZ = -15.71382656
DCZ = { sine = [-5.654488208, 0.029153537, -0.659438] }
EX0Z = -14.020150766
EY0Z = 1.053379485
EA0Z = -16.418138025
EYX = { table = [[-244.87536, -12.371262303], [-190.83735, 2.917447062], [-99.54345, -18.632313764], [-31.14116, 12.849326879], [-19.11633, -12.851378582], [-12.76195, -15.884888469], [29.35058, 3.554802577], [209.47279, -7.70901767], [321.63867, 15.407125623]] }
EZX = { poly = [0, -0.063488753794], of = "B1" }
EAX = { forward = 11.478236956, backward = { poly = [-28.378986436, 0.0047451854] } }
EBX = { forward = -21.395221666, backward = { poly = [20.384131649, -0.05193844216] } }
ECX = { poly = [0, 0.141951371606], of = "C" }
TXX = { poly = [0, -0.047848615342], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
TYX = [ { poly = [1.214254947, -0.049040958605] }, { sine = [-2.024517688, 0.015, 0.3] } ]
TBX = 1.477119193
DZX = [ { poly = [16.566495046, 0.04318648388] }, { sine = [12.679550157, 0.015, 0.3] } ]
EZ0X = -14.658859037
EC0X = 8.501926724
EXC = { poly = [0, 0.061117603483], of = "B1" }
EZC = { grid = [[12.194874755, 0.530183439, -17.30406942], [14.364704026, 1.090508685, -8.780851561], [-4.817532101, -15.016523626, -11.773017441]], at = [[-180, 0, 180], [18, 20.5, 25]], of = ["C", "T1"] }
EAC = { grid = [[15.944719379, 25.900490916, -11.991506153], [25.685297005, -28.42537657, 12.784938118], [-6.627744998, -1.112520144, 23.666665144]], at = [[-180, 0, 180], [18, 20.5, 25]], of = ["B1", "T1"] }
EBC = { sine = [-17.070543765, 0.035247938, -1.052325] }
ECC = { poly = [0, -0.010282015875], of = "Z" }
TYC = { forward = 18.973808252, backward = { poly = [-16.435655132, -0.086027965517] } }
TZC = { poly = [2.182642337, 0.028429601278, -0.000230382298611] }
TBC = { table = [[-159.9961, -19.308770898], [-22.51378, 16.188986022], [174.71554, -5.435003176]] }
TCC = { poly = [0, 0.117682726467], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
DYC = { grid = [[0.752820915, 0.839187735, 11.274225637], [-13.030599924, 8.243831627, -2.940840928], [-3.134991438, -10.212083083, -8.737267612]], at = [[-180, 0, 180], [18, 20.5, 25]], of = ["B1", "T1"] }
EY0C = 6.079763497
EZ0C = 14.304161405
EB0C = 18.492541461
EC0C = -11.676219955
EXY = { poly = [0, 0.00987703063], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EYY = { grid = [[-3.195995648, 8.39552685, -10.666194416], [-6.732539284, -5.458236598, -19.918657627], [15.475244966, -16.470196338, -15.954855153]], at = [[-400.0, 0, 400.0], [18, 20.5, 25]], of = ["Y", "T1"] }
EZY = { sine = [-2.099339957, 0.031005585, -2.164683] }
EAY = { poly = [0, -0.038428964823], of = "Z" }
EBY = { poly = [0, -5.76873338], of = "T1", reference = 20 }
ECY = [ { poly = [14.803914961, -0.058958865537] }, { sine = [14.526934844, 0.015, 0.3] } ]
DCY = { poly = [0, -1.917788394], of = "T1", reference = 20 }
EY0Y = 2.213965429
EYt = 1.456192986
EZw = -10.351982423
EAw = -0.071710077
ECw = -9.022050713
)";
  check(kText, {{"B1", 73.48517}, {"Z", -28.07221}, {"X", 238.29359}, {"C", -104.09096}, {"Y", 185.42565}},
        {{"T1", 20.88}, {"v.Z", -15.544}}, {{"B1", 0}, {"Z", -1}, {"X", -1}, {"C", -1}, {"Y", 1}},
        {{ErrorModel::rigid, Vec3(-275.2700047786523, 726.3879389177646, -680.8965217880054),
          Vec3(0.8296836593805696, 0.5221660213996503, 0.19740230863018532)},
         {ErrorModel::linear, Vec3(-275.2700051222271, 726.3879394552562, -680.8965221379847),
          Vec3(0.8296836600673678, 0.5221660220718322, 0.19740230910278758)},
         {ErrorModel::first_order, Vec3(-0.0016357006310177742, -0.045781682551781465, 0.0643855421499211),
          Vec3(-1.750453930582374e-05, 4.977209812490058e-05, -5.8053598170261046e-05), kFirstOrder}});
}

TEST(Regression, RandomMachine18) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w Z b X Y B t"
[units]
length = "m"
angle = "deg"
error_length = "nm"
error_angle = "mrad"
[axis.Z]
origin = [-0.253621, -0.163622, 0.30948]
direction = [0.798467, -0.764, 0.044212]
location = "frame"
errors_seen = "tool"
measured_at = [-0.1799, -0.0807, 0.0046]
[axis.X]
measured_at = [-0.1206, -0.296, 0.2854]
[axis.Y]
origin = [0.181683, 0.030318, 0.07477]
location = "after"
[axis.B]
origin = [-0.308136, -0.018076, 0.338363]
direction = [0.367868, 0.262224, -0.679477]
location = "frame"
[tool]
origin = [0.122654, -0.147453, 0.005392]
length = 0.143435
[workpiece]
origin = [-0.179257, -0.144355, 0.206435]
[errors]
EXZ = { forward = 1794.515690009, backward = { poly = [-16452.605875828, -35208.8149804175] } }
EYZ = { poly = [-10017.310485748, -40738.69247475, -36891.94805199999] }
EAZ = { poly = [0, 0.00350597], of = "T1", reference = 20 }
ECZ = { poly = [0, 0.072710055], of = "Z" }
TXZ = { poly = [0, -8.644159436], of = "v.Z" }
TZZ = { poly = [0, -2966.025813169], of = "T1", reference = 20 }
EYX = { poly = [0, 10.780339607278], of = "B" }
EZX = { grid = [[-3120.091932181, -3843.39288484, 4417.987632267], [-1120.619812961, -3387.072135148, 15045.779597587], [16195.616958186, -13965.312771487, -13113.930864941]], at = [[-0.4, 0, 0.4], [18, 20.5, 25]], of = ["Y", "T1"] }
EAX = [ { poly = [0.013815896, -0.030465025] }, { sine = [-0.026487718, 15.0, 0.3] } ]
TCX = { poly = [-0.020207673, 0.0108418, 0.18588298125] }
DZX = [ { poly = [-17415.919793366, -17150.094293945] }, { sine = [4118.666132296, 15.0, 0.3] } ]
EB0X = 0.025531567
EXY = { sine = [-3910.692550687, 12.775542805, -1.295604] }
EYY = { poly = [0, -164.249318519], of = "v.B" }
EZY = [ { poly = [13406.041468538, -23984.892086327498] }, { sine = [13189.555572761, 15.0, 0.3] } ]
EAY = { poly = [0, -0.0421559975], of = "Z" }
EBY = { poly = [0, 0.058035595], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
TXY = { poly = [0, -111.857109178], of = "v.Z" }
EZ0Y = -16672.023416428
EB0Y = -0.026035553
EC0Y = -0.017191643
EXB = { poly = [0, -192.673266099], of = "v.Y" }
EYB = { poly = [0, -89.795523831], of = "v.B" }
EZB = { forward = 16992.280407169, backward = { poly = [470.314373567, -51.441284658628] } }
EAB = { poly = [0, 3.7558633e-05], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EBB = { poly = [0, -0.000146321889], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
ECB = [ { poly = [0.000390188, 3.7340956e-05] }, { sine = [-0.01245962, 0.033333333, 0.3] } ]
TYB = { grid = [[-12392.974000934, 5464.108249644, 806.4364103], [15499.793653489, -19093.998620636, 18759.435411864], [-8109.583260619, 13560.202192082, -12462.981518521]], at = [[-0.4, 0, 0.4], [18, 20.5, 25]], of = ["Z", "T1"] }
TZB = { poly = [0, -47075.14982382], of = "X" }
TBB = { poly = [0.014104979, 0.000110815872, -3.7698735e-08] }
TCB = { poly = [0, -5.9120444e-05], times = { poly = [0, 0.2], of = "T1", reference = 20 } }
EA0B = -0.027876768
EC0B = 0.025658255
EYt = -16405.705066649
EAt = 0.028003838
EBt = 0.023124743
EXw = -6630.042191096
EYw = -12016.524363514
EAw = -0.015827086
EBw = -0.0209205
)";
  check(kText, {{"Z", -0.2034}, {"X", 0.0611}, {"Y", -0.25611}, {"B", 95.24536}},
        {{"T1", 24.06}, {"v.X", 27.155}, {"v.B", 30.265}}, {{"Z", 0}, {"X", 1}, {"Y", 0}, {"B", 1}},
        {{ErrorModel::rigid, Vec3(50.237702016506944, -209.16106024990168, -511.6753390737348),
          Vec3(-0.08979026005737721, -0.7410643637899121, 0.6654031243685903)},
         {ErrorModel::linear, Vec3(50.23770134150857, -209.1610601823858, -511.67533967707993),
          Vec3(-0.08979025999000252, -0.7410643656319433, 0.6654031256489261)},
         {ErrorModel::first_order, Vec3(-0.01767168326881574, 0.006154885612356035, -0.037071214581781455),
          Vec3(-5.5897076910414734e-05, -2.1227559478772157e-05, -3.1177271529532945e-05), kFirstOrder}});
}

TEST(Regression, SevenAxisDrillingMachine) {
  constexpr const char* kText = R"(format = 1
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
  check(
      kText,
      {{"X", -420.5}, {"Y", 350.25}, {"Z", 180.75}, {"Z1", 60.125}, {"A", 12.0}, {"B", -25.0}, {"B1", 30.0}},
      {}, {},
      {{ErrorModel::linear, Vec3(-1171.5184534688194, 872.7017448987197, 1213.4153457668897),
        Vec3(-0.8092716021872026, -0.18843634441485685, 0.5563912508576666)},
       {ErrorModel::first_order, Vec3(0.0076505330686409585, -0.035114691278381814, 0.02116815816382604),
        Vec3(-2.2055544427989498e-05, -4.359088616558456e-06, -3.355319691073536e-05), 1e-12, 1e-16}});
}

TEST(Regression, ThreeAxisMachineWithToolOffset_line) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w X b Y Z t"
[units]
error_length = "mm"
error_angle = "rad"
[axis.X]
location = "line"
direction = [1, 0, 0]
errors_seen = "body"
[axis.Y]
location = "line"
[axis.Z]
location = "line"
[tool]
origin = [0.5, -0.25, -120.0]
[workpiece]
origin = [0, 0, 0]
[errors]
EXX = { poly = [0.0, 3.1e-05, -4.2e-08, 1.5e-11] }
EYX = { poly = [0.0, -1.2e-05, 3.3e-08, 0.0] }
EZX = { poly = [0.0, 9e-06, -2.7e-08, 0.0] }
EAX = { poly = [0.0, 4.1e-08, -1.1e-10, 0.0] }
EBX = { poly = [0.0, -6.3e-08, 1.9e-10, 0.0] }
ECX = { poly = [0.0, 5.2e-08, 7e-11, 0.0] }
EXY = { poly = [0.0, -8e-06, 2.9e-08, 0.0] }
EYY = { poly = [0.0, 2.6e-05, -3.8e-08, 2.1e-11] }
EZY = { poly = [0.0, -1.4e-05, 1.7e-08, 0.0] }
EAY = { poly = [0.0, -3.6e-08, 2.3e-10, 0.0] }
EBY = { poly = [0.0, 2.8e-08, -1.3e-10, 0.0] }
ECY = { poly = [0.0, -4.4e-08, 1.6e-10, 0.0] }
EXZ = { poly = [0.0, 1.1e-05, -2.2e-08, 0.0] }
EYZ = { poly = [0.0, -7e-06, 1.8e-08, 0.0] }
EZZ = { poly = [0.0, -2.9e-05, 4.6e-08, -1.2e-11] }
EAZ = { poly = [0.0, 3.3e-08, -2.1e-10, 0.0] }
EBZ = { poly = [0.0, -5.1e-08, 1.4e-10, 0.0] }
ECZ = { poly = [0.0, 2.4e-08, -9e-11, 0.0] }
EC0X = -5.778e-05
EA0Z = -2.928e-05
EB0Z = 4.899e-05
)";
  check(kText, {{"X", 120.5}, {"Y", -85.25}, {"Z", -40.75}}, {}, {},
        {{ErrorModel::first_order, Vec3(-0.0058805127228125, 0.005442801501078125, 0.0027490600606875),
          Vec3(3.811598125e-06, 2.9620125e-07, 0.0), 1e-12, 1e-16}});
}

TEST(Regression, ThreeAxisMachineWithToolOffset_frame) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w X b Y Z t"
[units]
error_length = "mm"
error_angle = "rad"
[axis.X]
location = "frame"
direction = [1, 0, 0]
errors_seen = "body"
[axis.Y]
location = "frame"
[axis.Z]
location = "frame"
[tool]
origin = [0.5, -0.25, -120.0]
[workpiece]
origin = [0, 0, 0]
[errors]
EXX = { poly = [0.0, 3.1e-05, -4.2e-08, 1.5e-11] }
EYX = { poly = [0.0, -1.2e-05, 3.3e-08, 0.0] }
EZX = { poly = [0.0, 9e-06, -2.7e-08, 0.0] }
EAX = { poly = [0.0, 4.1e-08, -1.1e-10, 0.0] }
EBX = { poly = [0.0, -6.3e-08, 1.9e-10, 0.0] }
ECX = { poly = [0.0, 5.2e-08, 7e-11, 0.0] }
EXY = { poly = [0.0, -8e-06, 2.9e-08, 0.0] }
EYY = { poly = [0.0, 2.6e-05, -3.8e-08, 2.1e-11] }
EZY = { poly = [0.0, -1.4e-05, 1.7e-08, 0.0] }
EAY = { poly = [0.0, -3.6e-08, 2.3e-10, 0.0] }
EBY = { poly = [0.0, 2.8e-08, -1.3e-10, 0.0] }
ECY = { poly = [0.0, -4.4e-08, 1.6e-10, 0.0] }
EXZ = { poly = [0.0, 1.1e-05, -2.2e-08, 0.0] }
EYZ = { poly = [0.0, -7e-06, 1.8e-08, 0.0] }
EZZ = { poly = [0.0, -2.9e-05, 4.6e-08, -1.2e-11] }
EAZ = { poly = [0.0, 3.3e-08, -2.1e-10, 0.0] }
EBZ = { poly = [0.0, -5.1e-08, 1.4e-10, 0.0] }
ECZ = { poly = [0.0, 2.4e-08, -9e-11, 0.0] }
EC0X = -5.778e-05
EA0Z = -2.928e-05
EB0Z = 4.899e-05
)";
  check(kText, {{"X", 120.5}, {"Y", -85.25}, {"Z", -40.75}}, {}, {},
        {{ErrorModel::first_order, Vec3(-0.0068191227228125, -0.005004398498921875, 0.0027318850606875),
          Vec3(5.2801598125e-05, 2.957620125e-05, 0.0), 1e-12, 1e-16}});
}

TEST(Regression, GearGrinder) {
  constexpr const char* kText = R"(format = 1
[machine]
name = "regression"
chain = "w C X b Y Z A t"
[units]
angle = "rad"
error_length = "mm"
error_angle = "rad"
[axis.X]
direction = [1, 0, 0]
errors_seen = "body"
[axis.C]
direction = [0, 0, 1]
location = "frame"
errors_seen = "body"
[axis.Y]
location = "frame"
[axis.Z]
location = "frame"
[axis.A]
origin = [0, 0, 200.0]
order = ["location", "motion", "static", "-location"]
[tool]
origin = [0, 0, 0]
[workpiece]
origin = [0, 0, 0]
[errors]
EXX = -0.00725
EYX = 0.00165
EZX = 0.00735
EAX = 6.43e-06
EBX = 5.64e-06
ECX = -8.71e-06
EXY = -0.00478
EYY = -0.00759
EZY = 0.00014
EAY = 5.58e-06
EBY = -8e-07
ECY = -3.3e-07
EXZ = 0.00334
EYZ = -0.00223
EZZ = 0.00615
EAZ = -5.71e-06
EBZ = -8.08e-06
ECZ = -1e-08
EXA = -0.00942
EYA = 0.00829
EZA = 0.00711
EAA = -2.02e-06
EBA = -1.14e-06
ECA = 2.44e-06
EXC = 0.00561
EYC = 0.00571
EZC = -0.00996
EAC = 4.25e-06
EBC = -8.8e-07
ECC = -4.55e-06
EXt = 0.00477
EYt = 0.00642
EZt = -0.00532
EAt = 2.1e-06
EBt = 9.35e-06
ECt = -7.91e-06
EXw = 0.00846
EYw = -0.0035
EZw = -0.00938
EAw = -9.55e-06
EBw = -9.48e-06
ECw = 3.3e-06
EX0C = 0.00108
EY0C = -0.00982
EA0C = 9.23e-06
EB0C = 8.04e-06
EY0A = -0.0022
EZ0A = 0.00405
EC0A = -5.57e-06
EB0A = 9.84e-06
EC0Y = -1.36e-06
EA0Z = 4.86e-06
EB0Z = -9.41e-06
)";
  check(kText, {{"X", -55.5}, {"Y", 20.25}, {"Z", -30.125}, {"A", 0.5}, {"C", -1.2}}, {}, {},
        {{ErrorModel::rigid, Vec3(-88.15725358812344, 93.8129825282963, -5.612447715910194),
          Vec3(0.44683639734623704, -0.17374318086023707, 0.8775822133060827), 1e-11, 1e-14}});
}

}  // namespace
}  // namespace abbe
