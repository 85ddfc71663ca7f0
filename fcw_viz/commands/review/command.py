"""`fcw review`: in its page, in rerun, or in a few figures."""

from fcw_viz.commands.review.options import ReviewCommand


def run_review(command: ReviewCommand) -> int:
    """Run `fcw review`; returns the exit code."""
    from fcw.errors import UserError

    if command.json and not command.summary:
        raise UserError("--json needs --summary; add it, or leave out --json")
    if command.summary:
        pages = {
            "--port": command.port is not None,
            "--no-open": command.no_open,
            "--reviewer": command.reviewer is not None,
            "--dark": command.dark,
            "--rerun": command.rerun,
        }
        if given := [option for option, is_given in pages.items() if is_given]:
            raise UserError(f"--summary {' '.join(given)}: a summary is printed; leave out one or the other")
        from fcw_viz.commands.review.summary import print_summary

        print_summary(command.path, command.json)
        return 0
    if command.rerun:
        from fcw_viz.commands.review.rerun import review_in_rerun

        return review_in_rerun(command)
    from fcw_viz.commands.review.page import review_in_page

    return review_in_page(command)
