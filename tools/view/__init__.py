"""Runs as recordings of Rerun: `egosieve-view`.

    pictures    those of the run's input
    recording   what is written of a run
    command     the command line
"""
