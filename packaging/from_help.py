#!/usr/bin/env python3
"""Man pages and bash completions from the programs' own --help: from_help.py OUTPUT_FOLDER VERSION PROGRAM...

What a program says of itself is the one description; these are its other shapes."""
import gzip
import pathlib
import re
import subprocess
import sys


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def sections_of(text):
    """{"": what it is for, "Options": [(names, help)], "Subcommands": ...} from CLI11's layout."""
    sections, title = {"": []}, ""
    for line in text.splitlines():
        heading = re.fullmatch(r"([A-Z][A-Za-z ]*):(.*)", line)
        if heading and heading[1] == "Usage":
            continue
        if heading:
            title = heading[1]
            sections.setdefault(title, [])
            continue
        entry = re.match(r"  (\S.*?)(?:\s{2,}(.*))?$", line)
        if title == "":
            if line.strip():
                sections[""].append(line.strip())
        elif entry:
            sections[title].append([entry[1], entry[2] or ""])
        elif line.strip() and sections[title]:
            sections[title][-1][1] = (sections[title][-1][1] + " " + line.strip()).strip()
    return sections


def roff(text):
    return re.sub(r"^([.'])", r"\\&\1", text.replace("\\", "\\e").replace("-", "\\-"))


def entries(items):
    return "".join(f".TP\n.B {roff(name)}\n{roff(help)}\n" for name, help in items)


def page(program, version, top, commands):
    name = pathlib.Path(program).name
    out = [f'.TH {name.upper()} 1 "" "Stillpoint {version}" "User Commands"\n.SH NAME\n',
           f"{name} \\- {roff(' '.join(top['']).rstrip('.'))}\n.SH SYNOPSIS\n.B {name}\n",
           "[\\fIOPTIONS\\fR]" + (" \\fISUBCOMMAND\\fR [\\fIOPTIONS\\fR]" if commands else "") + "\n"]
    out.append(".SH OPTIONS\n" + entries(top.get("Options", [])))
    if commands:
        out.append(".SH SUBCOMMANDS\n")
    for command, sections in commands.items():
        out.append(f".SS {roff(command)}\n{roff(' '.join(sections['']))}\n")
        for title, items in sections.items():
            if title:
                out.append(entries(i for i in items if not i[0].startswith("-h,")))
    out.append(".SH EXIT STATUS\n0 done; 1 a threshold asked for was not met; 64 usage; 65 bad data; 66 no such input;\n"
               "69 device or peer absent; 73 cannot create output; 78 bad configuration.\n"
               ".SH SEE ALSO\nThe pages in /usr/share/doc/stillpoint.\n")
    return "".join(out)


def options_of(sections):
    return sorted({o for title, items in sections.items() if title for name, _ in items
                   for o in re.findall(r"--[a-z][a-z0-9-]*", name)})


def completion(name, top, commands):
    cases = "".join(f'    {c}) words="{" ".join(options_of(s))}" ;;\n' for c, s in commands.items())
    first = " ".join([*commands, *options_of(top)])
    function = f"_{name}_complete"
    return (f"# bash completion for {name}\n{function}() {{\n"
            '  local words current="${COMP_WORDS[COMP_CWORD]}"\n'
            f'  case "${{COMP_WORDS[1]}}" in\n{cases}    *) words="" ;;\n  esac\n'
            f'  [ "$COMP_CWORD" -gt 1 ] && [ -n "$words" ] || words="{first}"\n'
            '  COMPREPLY=($(compgen -W "$words" -- "$current"))\n'
            '  [ "${#COMPREPLY[@]}" -gt 0 ] && [ "${current#-}" != "$current" ] || COMPREPLY+=($(compgen -f -- "$current"))\n'
            f"}}\ncomplete -o filenames -F {function} {name}\n")


def main(out, version, programs):
    out = pathlib.Path(out)
    (out / "man").mkdir(parents=True, exist_ok=True)
    (out / "completions").mkdir(parents=True, exist_ok=True)
    for program in programs:
        name = pathlib.Path(program).name
        top = sections_of(help_of(program))
        commands = {entry[0].split()[0]: None for entry in top.get("Subcommands", [])}
        for command in commands:
            commands[command] = sections_of(help_of(program, command))
        text = page(program, version, top, commands)
        (out / "man" / f"{name}.1.gz").write_bytes(gzip.compress(text.encode(), 9, mtime=0))
        (out / "completions" / name).write_text(completion(name, top, commands))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
