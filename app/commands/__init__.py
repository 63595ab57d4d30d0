"""The commands of `nonius`: one file each, with `run(options, console) -> exit code`; imported when called."""
