// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/tracer_cli.h"

#include "grtx/apps/grtx/options.h"
#include "grtx/experiment/secondary_options.h"
#include "grtx/experiment/tracer_option_table.h"

namespace grtx::apps {
namespace {

template <typename Number>
void add_rule(CLI::Option* option, const experiment::InRange<Number>& rule) {
  option->check(in_range(rule.low, rule.high));
}
void add_rule(CLI::Option* option, const experiment::OneOf& rule) { option->check(one_of(rule)); }
void add_rule(CLI::Option* option, const experiment::AnyOf& rule) {
  std::vector<std::string> numbers;
  for (const auto number : rule.numbers) numbers.push_back(fmt::format("{}", number));
  option->check(one_of(std::move(numbers)));
}
void add_rule(CLI::Option* option, const experiment::ListOf& rule) {
  option->delimiter(',')->expected(static_cast<int>(rule.numbers));
}

/// Visitor of an option table that adds each option to a command.
auto adder(CLI::App* command) {
  return
      [command]<typename Value>(const std::string& name, Value& value, const char* description, const auto&... rule) {
        const std::string flag = "--" + name;
        if constexpr (NamedEnum<Value>) {
          add_choice(command, flag, value, description);
        } else {
          CLI::Option* option = command->add_option(flag, value, description);
          (add_rule(option, rule), ...);
        }
        if (name == "bvh-width") command->get_option(flag)->default_str("6");
      };
}

}  // namespace

void add_kernel_degree(CLI::App* command, unsigned& degree) {
  adder(command)("kernel-degree", degree, experiment::kKernelDegree, experiment::AnyOf{{2U, 4U}});
}

void add_secondary_options(CLI::App* command, experiment::SecondarySettings& settings) {
  experiment::visit_secondary(settings, adder(command));
}

void add_tracer_options(CLI::App* command, experiment::TracerSettings& settings) {
  experiment::visit_options(settings, adder(command));
}

void apply_tracer(experiment::TracerSettings& settings, const experiment::ChosenMachine& machine,
                  const CLI::App& command) {
  const auto named = [&](const std::string& key) { return command.count(experiment::flag_of(key)) > 0; };
  experiment::apply_tracer(settings, machine.tracer, named);
}

}  // namespace grtx::apps
