// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/settings.h"

namespace waystone {

void AddSetFlag(CLI::App& command, std::vector<std::string>& settings) {
  command
      .add_option("--set", settings,
                  "Set any option: NAME=VALUE, once for each; `waystone options` lists them")
      ->allow_extra_args(false);
}

void AddOptions(CLI::App& app, Run& run) {
  auto markdown = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("options", "List every option that --set changes");
  command->add_flag("--markdown", *markdown, "As docs/options.md has them");
  command->footer("Example: waystone options | grep fusion");
  command->callback([markdown, &run] {
    run = [markdown] {
      std::cout << (*markdown ? OptionsMarkdown() : OptionsText());
      return 0;
    };
  });
}

}  // namespace waystone
