"""Scores runs of egosieve against truth: `egosieve-eval`.

    run_folder          what a run holds: its lines and maps
    truth_masks, synthetic_truth, box_truth, drive_truth    forms of truth
    pixel_scores, uncertainty, boundary, stability          measures of pixels and outlines
    objects, identity                                       measures of objects
    trajectory          measures of the camera
    drive_scores, mask_scores, box_scores, further          collections of them for one drive
    evaluation          one run: eval.json, eval.csv, further.json
    suite, table, folds many runs
    plots, pages        figures
    command             the command line
"""
