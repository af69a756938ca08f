"""The figures of a drive that are compared: columns of suite.csv, and lines of a run's table."""

# By name: heading, and place in eval.json.
FIGURES = {
    "mean_auc": ("AUC", "scores/mean_auc"),
    "pooled_auc": ("pooled", "scores/pooled_auc"),
    "mean_average_precision": ("AP", "scores/mean_average_precision"),
    "mean_iou": ("IoU", "scores/mean_iou"),
    "mean_f": ("F", "scores/mean_f"),
    "mean_iou_best_threshold": ("IoU best", "scores/mean_iou_best_threshold"),
    "mean_boundary_f": ("bound. F", "scores/mean_boundary_f"),
    "object_recall": ("recall", "scores/object_recall/all/recall"),
    "false_objects_per_frame": ("false o.", "scores/false_objects_per_frame"),
    "expected_calibration_error": ("ECE", "scores/calibration/expected_calibration_error"),
    "brier": ("Brier", "scores/mean_brier"),
    "log_loss": ("log loss", "scores/mean_log_loss"),
    "area_under_sparsification_error": (
        "AUSE", "scores/uncertainty/area_under_sparsification_error"),
    "error_auc": ("err. AUC", "scores/uncertainty/error_auc"),
    "class_error_auc": ("by class", "scores/class_uncertainty/error_auc"),
    "mask_j": ("mask J", "masks/j"),
    "mask_boundary_f": ("mask F", "masks/boundary_f"),
    "mask_temporal_instability": ("mask T", "masks/temporal_instability"),
    "truth_temporal_instability": ("true T", "masks/temporal_instability_of_truth"),
    "mask_object_recall": ("m. rec.", "masks/object_recall/all/recall_at_0.5"),
    "mask_false_objects_per_frame": ("m. false", "masks/false_objects_per_frame"),
    "idf1": ("IDF1", "masks/identity/idf1"),
    "hota": ("HOTA", "masks/identity/hota"),
    "seconds_per_frame": ("s/frame", "seconds_per_frame"),
}
HEADINGS = {name: heading for name, (heading, _) in FIGURES.items()}


def value_at(place, evaluation):
    """Of eval.json; None where it has none."""
    for part in place.split("/"):
        evaluation = evaluation.get(part) if evaluation else None
    return evaluation


def figures_of(evaluation):
    """By name."""
    return {name: value_at(place, evaluation) for name, (_, place) in FIGURES.items()}
