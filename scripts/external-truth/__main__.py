"""leadr against Mitsuba 3: `python scripts/external-truth --help`. README.md says what is needed."""
import argparse
import sys
from pathlib import Path

try:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
except ImportError as error:
    sys.exit(f"{error}: install mitsuba, numpy and pillow (pip install mitsuba numpy pillow)")
mi.set_log_level(mi.LogLevel.Error)

import files


def arguments():
    parser = argparse.ArgumentParser(prog="external-truth", description="Compares leadr with Mitsuba 3.")
    add = parser.add_argument
    add("--out", type=Path, required=True, help="folder outside the repository for truths and pictures, which are kept there")
    add("--only", nargs="*", default=[], metavar="PATTERN", help="cases whose names match, such as sphere/spiaggia, 'plane/rock/*/diffuse', slopes")
    add("--ways", default="", metavar="NAME,...", help="ways of drawing, by name, such as '1 sample,reference 64', or none")
    add("--list", action="store_true", help="name the cases and end")
    add("--sheet", metavar="NAME", help="write a contact sheet, sheet-NAME.png, of the chosen cases")
    add("--record", metavar="LABEL", help="keep the numbers in results/LABEL.json and write the tables: before or after")
    add("--program", metavar="TEXT", help="what the tables call the binary, such as its commit [default: its version]")
    add("--store", action="store_true", help="store the truths of the chosen cases for the report's section 'outside'")
    return parser.parse_args()


def main():
    asked = arguments()
    files.OUT = asked.out.resolve()
    if files.OUT.is_relative_to(files.REPOSITORY) and not asked.list:
        sys.exit(f"--out {asked.out} lies in the repository; pictures belong elsewhere")
    import cases, program, score, tables

    chosen = cases.chosen([p for p in asked.only if p != "slopes"]) if not asked.only or asked.only != ["slopes"] else []
    if asked.list:
        print("\n".join([case.name for case in chosen] + ["slopes"]))
        return
    wanted = [way for way in asked.ways.split(",") if way and way != "none"]
    unknown = set(wanted) - set(cases.EVERY_WAY)
    if unknown:
        sys.exit(f"no way is called {', '.join(sorted(unknown))}; there are {', '.join(cases.EVERY_WAY)}")
    missing = [case for case in chosen if not case.available()]
    if missing:
        print(f"{len(missing)} cases need the shared data: set LEADR_SHARED", file=sys.stderr)
    chosen = [case for case in chosen if case not in missing]

    def ways(case):
        return {way: cases.EVERY_WAY[way] for way in wanted} if asked.ways else case.ways()

    found = dict(program=asked.program or program.version(), cases={}, slopes={})
    for case in chosen:
        found["cases"][case.name] = score.judge(case, ways(case))
        if asked.record:  # at once, so that a run may end early
            tables.keep(asked.record, found)
    if not asked.only or "slopes" in asked.only:
        import reliefs

        for name in ("studs", *reliefs.SHARED, *reliefs.MADE):
            if reliefs.heights(name) is not None:
                found["slopes"][name] = score.slopes(name)
    if asked.sheet and chosen:
        import sheets

        print(sheets.sheet(asked.sheet, [(case, ways(case)) for case in chosen]))
    if asked.store:
        import store

        store.write(chosen)
    if asked.record:
        tables.keep(asked.record, found)
        tables.write()


main()
