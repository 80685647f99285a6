#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes completion of the command line for bash (grtx.bash), zsh (_grtx) and fish (grtx.fish), from what `grtx --help`
and `grtx COMMAND --help` print: commands, options, values that have names, keys of --set, files elsewhere.

Usage: completions.py GRTX FOLDER
"""
import os
import shlex
import sys

import cli_help

NOTE = "# Completion for grtx: written by scripts/completions.py from what grtx --help prints."


def values(option, keys):
    return [key + "=" for key in keys] if "--set" in option.names else cli_help.named_values(option)


def bash(top, commands, keys):
    out = [NOTE, "_grtx() {", "  local current=$2 previous=$3 command='' options='' values='' i", "  COMPREPLY=()",
           "  for ((i = 1; i < COMP_CWORD; ++i)); do",
           "    [[ ${COMP_WORDS[i]} == -* ]] || { command=${COMP_WORDS[i]}; break; }", "  done", "  case $command in"]
    out.append('    "") options="' + " ".join([name for name, _ in top.commands] + [n for o in top.options for n in o.names]) + '" ;;')
    for command in commands:
        out.append(f'    {command.name}) options="{" ".join(n for o in command.options for n in o.names)}" ;;')
    out += ["    *) return ;;", "  esac", '  case "$command $previous" in']
    for command in commands:
        for option in command.options:
            if option.value:
                pattern = " | ".join(f'"{command.name} {name}"' for name in option.names)
                known = values(option, keys)
                text = "$_grtx_keys" if "--set" in option.names else " ".join(known)
                out.append(f"    {pattern}) values=" + (f'"{text}"' if known else ("-f" if option.is_file else "-")) + " ;;")
    out += ["  esac",
            '  case "$values" in',
            '    "") if [[ $current == -* || -z $command ]]; then', '          COMPREPLY=($(compgen -W "$options" -- "$current"))',
            "        else", '          mapfile -t COMPREPLY < <(compgen -f -- "$current")', "        fi ;;",
            '    -f) mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;', "    -) ;;",
            '    *) COMPREPLY=($(compgen -W "$values" -- "$current"))',
            "       [[ ${COMPREPLY[0]-} != *= ]] || compopt -o nospace 2>/dev/null ;;", "  esac",
            "  [[ $values != -f && ( -n $values || $current == -* ) ]] || compopt -o filenames 2>/dev/null", "}",
            f'_grtx_keys="{" ".join(key + "=" for key in keys)}"', "complete -F _grtx grtx"]
    return "\n".join(out) + "\n"


def zsh_text(text):
    """A description in an argument of _arguments, in single quotes."""
    for special in "\\[]:":
        text = text.replace(special, "\\" + special)
    return text.replace("'", "'\\''")


def zsh(top, commands, keys):
    def argument(option):
        message = zsh_text(option.description.split(" (")[0])
        known = values(option, keys)
        action = "_files" if option.is_file else f"({' '.join(known)})" if known and "--set" not in option.names else ""
        if "--set" in option.names:
            action = "{compadd -S '' -- $_grtx_keys}".replace("'", "'\\''")
        value = f":{option.value.lower()}:{action}" if option.value else ""
        if not option.names[0].startswith("-"):
            return f"'{'*' if option.repeated else ''}:{option.names[0].lower()}:_files'"
        if len(option.names) == 1:
            return f"'{'*' if option.repeated else ''}{option.names[0]}[{message}]{value}'"
        both = " ".join(option.names)
        return f"'({both})'{{{','.join(option.names)}}}'[{message}]{value}'"

    out = ["#compdef grtx", NOTE, "_grtx() {", "  local context state state_descr line", "  typeset -A opt_args",
           "  local -a _grtx_commands", "  _grtx_commands=("]
    out += [f"    '{name}:{zsh_text(summary)}'" for name, summary in top.commands]
    out += ["  )", "  local -a _grtx_keys", "  _grtx_keys=(" + " ".join(key + "=" for key in keys) + ")",
            "  _arguments -C " + " ".join(argument(option) for option in top.options) + " '1:command:->command' '*::argument:->rest'",
            "  case $state in", "    command) _describe command _grtx_commands ;;", "    rest)", "      case $words[1] in"]
    for command in commands:
        out.append(f"        {command.name})")
        out.append("          _arguments -s \\")
        lines = [argument(option) for option in command.options + command.arguments]
        out.append(" \\\n".join("            " + line for line in lines) + " ;;")
    out += ["      esac ;;", "  esac", "}", '_grtx "$@"']
    return "\n".join(out) + "\n"


def fish(top, commands, keys):
    out = [NOTE, "complete -c grtx -f"]
    names = " ".join(name for name, _ in top.commands)
    for name, summary in top.commands:
        out.append(f"complete -c grtx -n 'not __fish_seen_subcommand_from {names}' -a {name} -d {shlex.quote(summary)}")

    def lines(condition, options):
        for option in options:
            if not option.names[0].startswith("-"):
                out.append(f"complete -c grtx -n {condition} -F")
                continue
            line = f"complete -c grtx -n {condition}"
            for name in option.names:
                line += f" -l {name[2:]}" if name.startswith("--") else f" -s {name[1:]}"
            if option.value:
                known = values(option, keys)
                line += " -r -F" if option.is_file else f" -x -a {shlex.quote(' '.join(known))}" if known else " -x"
            out.append(line + f" -d {shlex.quote(option.description.split(' (')[0])}")

    lines(shlex.quote(f"not __fish_seen_subcommand_from {names}"), top.options)
    for command in commands:
        lines(f"'__fish_seen_subcommand_from {command.name}'", command.options + command.arguments)
    return "\n".join(out) + "\n"


def main():
    program, folder = sys.argv[1], sys.argv[2]
    os.makedirs(folder, exist_ok=True)
    top, *commands = cli_help.everything(program)
    keys = cli_help.keys(program)
    for name, made in (("grtx.bash", bash), ("_grtx", zsh), ("grtx.fish", fish)):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(made(top, commands, keys))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
