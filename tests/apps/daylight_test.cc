// `glowworm daylight`: a weather file in, tables out.
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "apps/program.h"

namespace glowworm {
namespace {

class DaylightTest : public ProgramTest {
 protected:
  /// Writes a floor, one sensor that faces up and one that faces the horizon, and a weather file of 21 June and the
  /// days after it.
  void write_inputs(int days = 1) const {
    std::ofstream(path("floor.obj")) << "o floor\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";
    std::ofstream(path("a.pts")) << "0 1 0 0 1 0\n0.5 1 0 0 0 1\n";
    std::ofstream epw(path("a.epw"));
    epw << "LOCATION,Munich,-,DEU,TEST,108660,48.13,11.70,1.0,529.0\n";
    for (int i = 2; i <= 7; ++i) epw << "HEADER\n";
    epw << "DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\n";
    for (int i = 0; i < 24 * days; ++i) {
      const int hour = i % 24 + 1;
      const bool by_day = hour > 6 && hour < 19;
      epw << "1999,6," << 21 + i / 24 << ',' << hour << ",60,?9?9,20,10,50,95000,1000,1300,350," << (by_day ? 600 : 0)
          << ',' << (by_day ? 500 : 0) << ',' << (by_day ? 200 : 0) << ",0,0\n";
    }
  }

  Outcome daylight(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"daylight",  "floor.obj", "--epw",    "a.epw", "--points",  "a.pts",
                                      "--samples", "4",         "--gather", "64",    "--photons", "5000"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};
using SlowDaylightTest = DaylightTest;

/// Rays to the actual suns follow the last Job.
TEST_F(DaylightTest, InterruptAfterTheRoundsEndsAtOnceAndLeavesNothing) {
  write_inputs(10);
  std::ofstream points(path("b.pts"));
  for (int i = 0; i < 20'000; ++i) points << "0 " << 0.5 + 1e-6 * i << " 0 0 1 0\n";
  points.close();
  Running program(folder_, {"daylight", "floor.obj", "--epw", "a.epw", "--points", "b.pts", "--samples", "4",
                            "--gather", "1", "--photons", "2000", "--sun-step", "30", "-v", "-o", "y.csv"});
  ASSERT_TRUE(program.wait_for_text("round 2:", 300));
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 128 + SIGINT);
  EXPECT_FALSE(std::filesystem::exists(path("y.csv")));
}

TEST_F(DaylightTest, WritesTheYearAndItsMetrics) {
  write_inputs();
  const Outcome outcome = daylight({"-o", "y.csv", "--metrics", "m.json", "--box", "left,-1,0,-1,0.2,2,1",
                                    "--write-matrix", "m.mtx", "--write-sky", "s.smx"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("has 24 hours"));
  EXPECT_THAT(outcome.err, testing::HasSubstr("left: 1 sensors, sDA(300 lx, 50%) 100.0%"));
  const std::string table = read(path("y.csv"));
  EXPECT_THAT(table, testing::HasSubstr("\nmonth,day,hour,E0,E1\n"));
  EXPECT_THAT(table, testing::HasSubstr("\n6,21,1,0,0\n"));
  EXPECT_THAT(read(path("m.mtx")), testing::HasSubstr("NROWS=2\nNCOLS=146\n"));
  EXPECT_THAT(read(path("s.smx")), testing::HasSubstr("NROWS=146\nNCOLS=24\n"));
  const nlohmann::json metrics = read_json("m.json");
  ASSERT_EQ(metrics["sensors"].size(), 2u);
  EXPECT_EQ(metrics["sensors"][0]["DA"], 1);
  EXPECT_EQ(metrics["sensors"][0]["sun_hours"], 10);
  EXPECT_FALSE(metrics["sensors"][0].contains("DGPs_hours")) << "faces up";
  EXPECT_GT(metrics["sensors"][1]["DGPs_hours"], 0.5);
  EXPECT_NEAR(metrics["sensors"][0]["daylight_factor"], 1, 0.05);
  ASSERT_EQ(metrics["zones"].size(), 2u);
  EXPECT_EQ(metrics["zones"][0]["ASE"], 0) << "ten hours are few";
  // The sky that it wrote gives the same year.
  ASSERT_EQ(daylight({"-o", "z.csv", "--sky-matrix", "s.smx"}).status, 0);
  const std::string again = read(path("z.csv"));
  EXPECT_EQ(again.substr(again.find("\nmonth")).substr(0, 300), table.substr(table.find("\nmonth")).substr(0, 300));
}

TEST_F(DaylightTest, RatesZones) {
  write_inputs();
  const Outcome outcome =
      run({"daylight", "floor.obj", "--epw", "a.epw", "--zone", "desk=-1,0.8,-1,1,0.8,1,1", "--zone", "ground=floor,1",
           "--samples", "4", "--gather", "64", "--photons", "5000", "--metrics", "m.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json metrics = read_json("m.json");
  ASSERT_EQ(metrics["zones"].size(), 3u);
  EXPECT_EQ(metrics["zones"][1]["name"], "desk");
  EXPECT_EQ(metrics["zones"][1]["sensors"], 4) << "without eyes";
  EXPECT_EQ(metrics["zones"][2]["name"], "ground");
  EXPECT_EQ(metrics["zones"][1]["sDA"], 1);
}

TEST_F(DaylightTest, TakesShadesBySchedule) {
  write_inputs();
  std::ofstream(path("roof.obj")) << "o floor\nv -9 1.2 -9\nv -9 1.2 9\nv 9 1.2 9\nv 9 1.2 -9\nf 1 2 3 4\n";
  std::ofstream schedule(path("s.txt"));
  for (int hour = 1; hour <= 24; ++hour) schedule << (hour == 12 ? 1 : 0) << '\n';
  schedule.close();
  const Outcome outcome = daylight({"-o", "y.csv", "--shade", "roof.obj", "--shade-schedule", "s.txt"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string table = read(path("y.csv"));
  const auto lux = [&](const std::string& hour) {
    const std::string row = "\n6,21," + hour + ",";
    return std::stod(table.substr(table.find(row) + row.size()));
  };
  EXPECT_LT(lux("12"), 0.2 * lux("11"));
  EXPECT_GT(lux("13"), 0.8 * lux("11"));
}

/// Without sensors the eyes are the sensors.
TEST_F(SlowDaylightTest, RatesViews) {
  write_inputs();
  // So little light that no index is at its bound.
  std::string weather = read(path("a.epw"));
  const std::string day = ",600,500,200,", dim = ",20,10,15,";
  for (std::size_t at = weather.find(day); at != std::string::npos; at = weather.find(day))
    weather.replace(at, day.size(), dim);
  std::ofstream(path("a.epw")) << weather;
  std::ofstream(path("v.vf")) << "rview -vp 0 1 0 -vd 1 0.1 0 -vu 0 1 0\nrview -vp 0 1 0 -vd 0 -1 0 -vu 1 0 0\n";
  const Outcome outcome = run({"daylight", "floor.obj", "--epw", "a.epw", "--views", "v.vf", "--dgp", "g.csv", "--side",
                               "24", "-o", "y.csv", "--samples", "16", "--photons", "100000"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("view 1: DGP"));
  EXPECT_THAT(outcome.err, testing::HasSubstr("is exceeded in 5% of the occupied hours"));
  EXPECT_THAT(outcome.err, testing::HasSubstr("standard error of DGP 0.0"));
  const std::string table = read(path("g.csv")), sensors = read(path("y.csv"));
  EXPECT_THAT(table,
              testing::HasSubstr("\nmonth,day,hour,DGP1,E_v1_lx,DGP1_error,E_v1_error_lx,DGP2,E_v2_lx,DGP2_error,"
                                 "E_v2_error_lx\n6,21,1,0.000,0,0,0,0.000,0,0,0\n"));
  const auto numbers = [](const std::string& text, const std::string& hour) {
    const std::string row = "\n6,21," + hour + ",";
    std::vector<double> out;
    std::istringstream in(text.substr(text.find(row) + row.size()));
    std::string line, word;
    std::getline(in, line);
    std::istringstream words(line);
    while (std::getline(words, word, ',')) out.push_back(std::stod(word));
    return out;
  };
  // In the morning the sun is in the east.
  const std::vector<double> morning = numbers(table, "8"), evening = numbers(table, "17");
  EXPECT_GT(morning[0], 0.5);
  EXPECT_LT(evening[0], 0.4);
  EXPECT_GT(evening[0], 0.1);
  // No sensor is measured for glare alone.
  const Outcome alone = run({"daylight", "floor.obj", "--epw", "a.epw", "--views", "v.vf", "--dgp", "h.csv", "--side",
                             "24", "--photons", "100000"});
  ASSERT_EQ(alone.status, 0) << alone.err;
  EXPECT_THAT(alone.err, testing::Not(testing::HasSubstr("rounds in")));
  const auto rows = [](const std::string& text) { return text.substr(text.find("\nmonth")); };
  EXPECT_EQ(rows(read(path("h.csv"))), rows(table));
  for (const char* hour : {"8", "13", "17"})
    EXPECT_NEAR(numbers(table, hour)[1] / numbers(sensors, hour)[0], 1, 0.06) << hour;
}

TEST_F(DaylightTest, RefusesWhatDoesNotFit) {
  write_inputs();
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--dgp", "g.csv"}), {"--views"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--side", "64"}), {"--side", "--views"}, 2));
  EXPECT_TRUE(refused(daylight({}), {"no output"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.txt"}), {"y.txt", ".csv"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--hours", "18-8"}), {"18-8"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--sky", "cie:16"}), {"--sky"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--environment-scale", "2"}), {"--environment-scale"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--udi", "300,100,3000"}), {"--udi"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--shade", "floor.obj"}), {"--shade-schedule"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "y.csv", "--box", "a,1,2"}), {"--box"}, 2));
  EXPECT_TRUE(refused(daylight({"-o", "a.epw.csv", "--schedule", "a.pts"}), {"a.pts"}));
  EXPECT_FALSE(std::filesystem::exists(path("y.csv")));
}

}  // namespace
}  // namespace glowworm
