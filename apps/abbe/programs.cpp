// The verbs that read programs: compensate, check, verify, diff, explain.

#include <fmt/format.h>

#include <memory>
#include <string>

#include "abbe/core/number.h"
#include "abbe/pipeline/diff_programs.h"
#include "abbe/report/json_writer.h"
#include "command_line.h"
#include "program_options.h"
#include "progress.h"
#include "verbs.h"

namespace abbe::app {
namespace {

Exit exit_of(ProgramEnd end) {
  switch (end) {
    case ProgramEnd::done:
      return Exit::done;
    case ProgramEnd::io:
      return Exit::internal;
    case ProgramEnd::invalid:
      return Exit::invalid;
    case ProgramEnd::refused:
      return Exit::refused;
    case ProgramEnd::outside:
      return Exit::outside;
    case ProgramEnd::disagrees:
      return Exit::disagrees;
    case ProgramEnd::stopped:
      return Exit::interrupted;
  }
  return Exit::internal;
}

void tell(const ProgramOutcome& outcome, const ProgramArguments& arguments, const std::string& output,
          Session& session) {
  session.report(outcome.diagnostics, exit_of(outcome.end));
  if (outcome.end != ProgramEnd::done) session.note(exit_of(outcome.end));
  const auto& limit = arguments.common.limit_um;
  if (session.strict && limit && outcome.verify.after.max > *limit * um) session.note(Exit::warnings);
  // standard output belongs to the program when that is where it goes
  const std::string& text = arguments.common.json ? outcome.json : outcome.text;
  if (output == "-") {
    if (!arguments.common.json) fmt::print(stderr, "{}", text);
    return;
  }
  session.out.write(text);
  if (!text.empty() && text.back() != '\n') session.out.write("\n");
}

struct RewriteArguments {
  ProgramArguments program;
  std::string input, output;
  unsigned threads = 0;
};

void add_threads(Command& verb, RewriteArguments& arguments) {
  verb.add_option("--threads", arguments.threads,
                  "1: verify after rewriting, not at the same time; the result does not depend on it")
      ->check(whole_in(1, 4096))
      ->type_name("N");
}

void run_rewrite(const RewriteArguments& arguments, Session& session, bool check) {
  if (!check && arguments.output == "-" && arguments.program.common.json) {
    session.report(option_error("--json", "standard output cannot hold the program and the report",
                                "write the report with --report"));
    return;
  }
  auto setting = load_program_setting(arguments.program, arguments.input, session);
  if (!setting) return;
  setting->job.program = arguments.input;
  setting->job.threads = arguments.threads;
  if (!check) setting->job.output = arguments.output;
  ProgramOutcome outcome;
  {
    ProgressBar bar(fmt::format("{} {}", check ? "check" : "compensate", arguments.input));
    outcome = compensate_program(setting->plan, setting->job, bar.callback());
  }
  tell(outcome, arguments.program, check ? "" : arguments.output, session);
}

}  // namespace

Verb compensate_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<RewriteArguments>();
  Command* verb = program.add_subcommand(
      "compensate", "rewrite a program so that the machine's errors cancel, verify it, then publish it");
  add_program_options(*verb, arguments->program, session);
  verb->add_option("program", arguments->input, "program, or - for standard input");
  verb->add_option("-o,--output", arguments->output,
                   "where the compensated program goes, or - for standard output")
      ->required();
  verb->add_option("--header", arguments->program.header, "where the output says what it is")
      ->check(one_of({"inline", "sidecar", "none"}))
      ->capture_default_str();
  add_threads(*verb, *arguments);
  return {verb, [arguments, &session] {
            if (settle_files(arguments->program.common, {&arguments->input}, session))
              run_rewrite(*arguments, session, false);
          }};
}

Verb check_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<RewriteArguments>();
  Command* verb = program.add_subcommand("check", "everything compensate does, without an output");
  add_program_options(*verb, arguments->program, session);
  verb->add_option("program", arguments->input, "program, or - for standard input");
  add_threads(*verb, *arguments);
  return {verb, [arguments, &session] {
            if (settle_files(arguments->program.common, {&arguments->input}, session))
              run_rewrite(*arguments, session, true);
          }};
}

Verb verify_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<RewriteArguments>();
  Command* verb = program.add_subcommand(
      "verify", "compare a compensated program with its original: path, events, feeds, rapid or feed");
  add_program_options(*verb, arguments->program, session);
  verb->add_option("original", arguments->input, "the original program");
  verb->add_option("compensated", arguments->output, "the compensated program");
  return {verb, [arguments, &session] {
            if (!settle_files(arguments->program.common, {&arguments->input, &arguments->output}, session))
              return;
            auto setting = load_program_setting(arguments->program, arguments->input, session);
            if (!setting) return;
            setting->job.program = arguments->input;
            ProgramOutcome outcome;
            {
              ProgressBar bar(fmt::format("verify {}", arguments->output));
              outcome = verify_programs(setting->plan, setting->job, arguments->output, bar.callback());
            }
            tell(outcome, arguments->program, "", session);
          }};
}

Verb diff_verb(Command& program, Session& session) {
  struct Arguments {
    std::string original, output;
    bool json = false;
    std::size_t lines = 20;
    ProfileArguments profile;
  };
  auto arguments = std::make_shared<Arguments>();
  Command* verb =
      program.add_subcommand("diff", "what changed between a program and its compensated form, word by word");
  verb->add_option("original", arguments->original, "the original program")->required();
  verb->add_option("compensated", arguments->output, "the compensated program")->required();
  verb->add_flag("--json", arguments->json, "answer as JSON");
  verb->add_option("--dialect", arguments->profile.dialect,
                   "control the programs are for, where its words have names (siemens)");
  verb->add_option("--profile", arguments->profile.file, "the same from a profile file");
  verb->add_option("--most", arguments->lines, "how many changed words to list, 0 = all")
      ->capture_default_str();
  return {
      verb, [arguments, &session] {
        const auto profile = load_profile(arguments->profile, session);
        if (!profile) return;
        if (profile->text.conversational) {
          return session.report(option_error(
              "--dialect", "conversational programs are not compared word by word: blocks are renumbered",
              "see that they are the same program with abbe verify"));
        }
        std::size_t listed = 0;
        std::string changes;
        JsonWriter json;
        if (arguments->json) {
          json.begin_object();
          json.key("changes");
          json.begin_array();
        }
        const DiffReport report = diff_programs(
            arguments->original, arguments->output,
            [&](const WordChange& change) {
              if (arguments->lines != 0 && listed >= arguments->lines) return;
              ++listed;
              if (arguments->json) {
                json.begin_object();
                json.member("line", change.line_in);
                json.member("output_line", change.line_out);
                json.member("word", std::string(1, change.letter));
                json.member("before", change.text_before);
                json.member("after", change.text_after);
                json.end();
                return;
              }
              if (change.added)
                changes += fmt::format("{:>8} {:>8}  {}  {:>14}  {:>14}  added\n", change.line_in,
                                       change.line_out, change.letter, "", change.text_after);
              else
                changes += fmt::format("{:>8} {:>8}  {}  {:>14}  {:>14}  {:+.5f}\n", change.line_in,
                                       change.line_out, change.letter, change.text_before, change.text_after,
                                       change.after - change.before);
            },
            profile.get());
        session.report(report.diagnostics, report.readable ? Exit::disagrees : Exit::invalid);
        if (!report.readable) return;
        if (arguments->json) {
          json.end();
          json.member("same_program", report.same_program);
          json.member("changed_words", report.changed_words);
          json.member("added_words", report.added_words);
          json.member("added_blocks", report.added_blocks);
          json.member("header_lines", report.header_lines);
          json.member("taken_up", report.taken_up);
          json.end();
          session.out.write(json.take() + "\n");
          return;
        }
        if (listed > 0)
          session.out.write(
              "    line   output      before           after           change (program units)\n" + changes);
        if (report.changed_words + report.added_words > listed)
          session.out.write(fmt::format("  ... {} more (--most 0 lists all)\n",
                                        report.changed_words + report.added_words - listed));
        session.out.write(fmt::format("{} words changed, {} added, {} blocks added, {} header lines\n",
                                      report.changed_words, report.added_words, report.added_blocks,
                                      report.header_lines));
        if (report.taken_up > 0)
          session.out.write(fmt::format("{} arcs begin with a straight move (G1) that takes up lost motion\n",
                                        report.taken_up));
        session.out.write(report.same_program
                              ? "apart from these numbers the program is the same, byte for byte\n"
                              : "the programs differ in more than numbers\n");
      }};
}

Verb explain_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<RewriteArguments>();
  Command* verb = program.add_subcommand(
      "explain", "why a block is rewritten as it is: frames, position, correction, decision");
  add_program_options(*verb, arguments->program, session);
  verb->add_option("place", arguments->input, "FILE:LINE");
  return {verb, [arguments, &session] {
            if (!settle_files(arguments->program.common, {&arguments->input}, session)) return;
            const std::size_t colon = arguments->input.rfind(':');
            const auto line = colon == std::string::npos
                                  ? std::nullopt
                                  : read_number(std::string_view(arguments->input).substr(colon + 1));
            if (!line || *line < 1 || *line > 1e15) {
              session.report(option_error("explain", fmt::format("'{}' is not FILE:LINE", arguments->input),
                                          "write part.ngc:120"));
              return;
            }
            auto setting =
                load_program_setting(arguments->program, arguments->input.substr(0, colon), session);
            if (!setting) return;
            setting->job.program = arguments->input.substr(0, colon);
            setting->job.trace_line = static_cast<std::uint64_t>(*line);
            const ProgramOutcome outcome = compensate_program(setting->plan, setting->job);
            session.report(outcome.diagnostics, exit_of(outcome.end));
            if (outcome.end != ProgramEnd::done) session.note(exit_of(outcome.end));
            const auto& trace = outcome.rewrite.trace;
            if (!trace) {
              if (outcome.end == ProgramEnd::done)
                session.out.write("nothing is executed on that line: it is copied\n");
              return;
            }
            const auto vec = [](const Vec3& v) {
              return fmt::format("X {:.4f}  Y {:.4f}  Z {:.4f}", v.x(), v.y(), v.z());
            };
            const auto in_um = [](const Vec3& v) {
              return fmt::format("X {:+.2f}  Y {:+.2f}  Z {:+.2f} um", v.x() / um, v.y() / um, v.z() / um);
            };
            if (arguments->program.common.json) {
              JsonWriter json;
              json.begin_object();
              json.member("frame", trace->frame);
              const auto vector = [&](const char* name, const Vec3& v, double unit) {
                json.member(name, Vec3(v / unit));
              };
              vector("frame_origin_mm", trace->frame_origin, 1);
              vector("g92_mm", trace->g92, 1);
              vector("tool_offset_mm", trace->tool_offset, 1);
              vector("datum_um", trace->datum, um);
              json.member("gauge_length_mm", trace->gauge_length);
              vector("start_mm", trace->start, 1);
              vector("end_mm", trace->end, 1);
              vector("correction_um", trace->correction, um);
              json.member("decision", trace->decision);
              json.member("before", trace->before);
              json.member("after", trace->after);
              json.end();
              session.out.write(json.take() + "\n");
              return;
            }
            std::string text = fmt::format("{}\n  - {}\n", arguments->input, trace->before);
            std::string_view after = trace->after;
            while (!after.empty()) {
              const std::size_t end = std::min(after.find('\n'), after.size());
              std::string_view piece = after.substr(0, end);
              if (!piece.empty() && piece.back() == '\r') piece.remove_suffix(1);
              text += fmt::format("  + {}\n", piece);
              after.remove_prefix(std::min(end + 1, after.size()));
            }
            text += fmt::format("  frame       {} at {} mm", trace->frame, vec(trace->frame_origin));
            if (trace->g92 != Vec3::Zero()) text += fmt::format(", G92/G52 {}", vec(trace->g92));
            text += fmt::format(
                "\n  tool        {}, offset {} mm, gauge length {:.4f} mm\n",
                trace->tool ? fmt::format("T{}", *trace->tool) : std::string("of the machine file"),
                vec(trace->tool_offset), trace->gauge_length);
            text += fmt::format("  axes        from {} mm\n              to   {} mm\n", vec(trace->start),
                                vec(trace->end));
            text += fmt::format("  correction  {}   (datum removed: {})\n  decision    {}\n",
                                in_um(trace->correction), in_um(trace->datum), trace->decision);
            session.out.write(text);
          }};
}

}  // namespace abbe::app
