// Tables of measurements: written as Markdown, with the command, the machine, the instruction set, the threads, the
// commit and the spread of repeated runs.
#pragma once
#include <functional>
#include <string>
#include <variant>
#include <vector>

namespace glowworm::bench {

/// A quantity that was measured several times: median and range. In whatever unit was measured.
struct Spread {
  double median = 0, least = 0, most = 0;
  int runs = 0;  ///< 0: not measured

  /// The same with every value times `factor`, which is above 0.
  Spread scaled(double factor) const { return {median * factor, least * factor, most * factor, runs}; }
  /// `amount` over every value: a rate from times.
  Spread rate(double amount) const { return {amount / median, amount / most, amount / least, runs}; }
};

/// Median (the mean of the middle two of an even number) and range. @param values at least one
Spread spread_of(std::vector<double> values);

/// Wall seconds of so many runs of `work`, each of which is counted.
Spread measure_seconds(int runs, const std::function<void()>& work);

/// A number, shown with so many significant digits.
struct Number {
  double value;
  int digits = 3;
};

/// What stands in a field of a table. monostate: nothing, shown as a dash.
using Cell = std::variant<std::monostate, std::string, Number, Spread>;

/// A table that is filled row by row. Every row notes simd_name() and thread_count() as they are when it is added.
class Table {
 public:
  /// @param name     of the files, without extension: a short lower-case word of its own
  /// @param title    what the table shows, one line
  /// @param columns  heads with units, such as "query, s"; instruction set and threads need not be named
  Table(std::string name, std::string title, std::vector<std::string> columns);

  /// Adds a row and prints it, so that a long run is seen to go on. Throws Error where the number of cells is not that
  /// of the columns.
  void add(std::vector<Cell> cells);
  /// Adds a line below the table.
  void note(std::string text);

  /// The whole table as Markdown: medians, with the range in brackets where there were several runs.
  std::string markdown() const;
  /// Writes NAME.md into the folder, which is made where it is not there. Throws Error where it cannot.
  void write(const std::string& folder = "bench/results") const;

 private:
  struct Row {
    std::vector<Cell> cells;
    std::string simd;
    int threads;
  };
  std::string row_markdown(const Row& row) const;

  std::string name_, title_;
  std::vector<std::string> columns_, notes_;
  std::vector<Row> rows_;
};

/// The processor's name and cores, such as "AMD EPYC, 2 cores".
std::string machine_name();

/// The command that runs, without the program's folder, such as "tables lanes".
std::string command_line();

/// The commit of the working folder with "-dirty" where it was changed since; "unknown" outside of a repository.
std::string commit_name();

}  // namespace glowworm::bench
