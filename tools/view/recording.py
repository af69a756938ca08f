"""A run as a recording of Rerun (rerun-sdk): on the timelines `frame`, the index in the input, and `time`, seconds.

    world/camera                  pose of the camera, where the run has a trajectory; world/path: all of them, static
    world/camera/image            the picture, JPEG; with the focal length a pinhole camera
    world/camera/image/masks      the movers' pixels; the class is the mover's number, 0 is static
    world/camera/image/movers     boxes with the movers' numbers
    probability                   of moving, on the run's grid, 0 to 255
    doubt/expected_overlap        the IoU that the map expects of its own mask; doubt/threshold: below it a frame is unreliable
    doubt/why                     why a frame is unreliable, text

Each frame is written when it is read, so that memory does not grow with the drive.
"""

import csv
import json

import cv2
import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from evaluate.files import InputError, read_numbers

CAMERA, IMAGE = "world/camera", "world/camera/image"
UNRELIABLE = 0.4  # tools/run_folder/doubtful_frames.cc
JPEG_QUALITY = 85
# As MoverColour in tools/render/overlay.cc: red, green, blue by number modulo 12.
COLOURS = ((68, 119, 170), (238, 102, 119), (34, 136, 51), (204, 187, 68), (102, 204, 238), (170, 51, 119),
           (238, 119, 51), (119, 221, 153), (255, 170, 221), (17, 51, 102), (68, 204, 136), (255, 153, 153))  # fmt: skip


def blueprint(has_poses):
    """Pictures large; probability, and poses where there are some, beside them; doubt below."""
    beside = [rrb.Spatial2DView(origin="probability", name="Probability of moving")]
    if has_poses:
        beside.append(rrb.Spatial3DView(origin="world", name="Camera"))
    why = rrb.TextLogView(origin="doubt/why", name="Why unreliable", columns=rrb.TextLogColumns(timeline_columns=["time"], text_log_columns=["body"]))
    doubt = rrb.TimeSeriesView(origin="doubt", name="Expected IoU; below 0.4 a frame is unreliable")
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(rrb.Spatial2DView(origin=IMAGE, name="Movers"), rrb.Vertical(*beside), column_shares=[2, 1]),
            rrb.Horizontal(doubt, why, column_shares=[2, 1]),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(timeline="time", state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def read_movers(path):
    """The rows of tracks.csv by frame; none where it is not there."""
    movers = {}
    if path.exists():
        with open(path, newline="", encoding="utf-8") as rows:
            for row in csv.DictReader(rows):
                movers.setdefault(int(row["frame"]), []).append(row)
    return movers


def read_poses(path):
    """(translation, quaternion xyzw), camera to world, by the time as trajectory.txt writes it; none where it is not there."""
    lines = path.read_text().splitlines() if path.exists() else []
    rows = [line.split() for line in lines if not line.startswith("#")]
    return {row[0]: (np.array(row[1:4], float), np.array(row[4:8], float)) for row in rows}


def read_table(read, path):
    """What `read` makes of a file; InputError where it is damaged."""
    try:
        return read(path)
    except (ValueError, KeyError, TypeError, IndexError):
        raise InputError(f"{path} is damaged; make it again") from None


def log_statics(record, run, movers, poses):
    """What holds for the whole drive."""
    numbers = sorted({int(row["id"]) for rows in movers.values() for row in rows})
    classes = [rr.AnnotationInfo(id=0, label="static", color=(0, 0, 0, 0))]
    classes += [rr.AnnotationInfo(id=n, label=f"mover {n}", color=COLOURS[n % len(COLOURS)]) for n in numbers]
    record.log(IMAGE, rr.AnnotationContext(classes), static=True)
    record.log("world", rr.ViewCoordinates.RDF, static=True)
    if poses:
        record.log("world/path", rr.LineStrips3D([[place for place, _ in poses.values()]]), static=True)
    camera = run.path / "camera.json"
    if poses and camera.exists():
        lens, size = json.loads(camera.read_text()), run.description["input"]
        width, height = size["width_pixels"], size["height_pixels"]
        focal = lens["focal_pixels"] * max(width, height) / max(lens["width"], lens["height"])
        record.log(IMAGE, rr.Pinhole(focal_length=focal, width=width, height=height, camera_xyz=rr.ViewCoordinates.RDF), static=True)
    record.log("doubt/threshold", rr.SeriesLines(names="unreliable below", colors=(200, 90, 30)), static=True)
    record.log("doubt/expected_overlap", rr.SeriesLines(names="expected IoU", colors=(31, 111, 174)), static=True)


def log_movers(record, run, line, rows):
    """The mask, and the boxes with their numbers."""
    ids = run.frame_file("ids", line)
    if ids.exists():
        numbers = read_numbers(ids, line.size)
        record.log(f"{IMAGE}/masks", rr.SegmentationImage(numbers.astype(np.uint8 if numbers.max() < 256 else np.uint16), opacity=0.5))
    boxes = np.array([[float(row[side]) for side in ("left", "top", "width", "height")] for row in rows]).reshape(-1, 4)
    numbers = [int(row["id"]) for row in rows]
    record.log(f"{IMAGE}/movers", rr.Boxes2D(mins=boxes[:, :2], sizes=boxes[:, 2:], class_ids=numbers, labels=[f"mover {n}" for n in numbers], show_labels=True))


def log_frame(record, run, line, picture, rows, pose):
    """One frame, at its place on both timelines."""
    record.set_time("frame", sequence=line.index)
    record.set_time("time", duration=line.time_seconds)
    jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    record.log(IMAGE, rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
    log_movers(record, run, line, rows)
    probability = (run.maps(line)[0] >> 8).astype(np.uint8)
    record.log("probability", rr.DepthImage(probability, meter=255, depth_range=[0, 255], colormap="inferno"))
    if pose:
        record.log(CAMERA, rr.Transform3D(translation=pose[0], quaternion=pose[1]))
    if line.expected_overlap is not None:
        record.log("doubt/expected_overlap", rr.Scalars(line.expected_overlap))
        record.log("doubt/threshold", rr.Scalars(UNRELIABLE))
    if doubt := doubt_of(line):
        record.log("doubt/why", rr.TextLog(doubt, level="WARN"))


def doubt_of(line):
    """Why the frame is unreliable, as the run's own commands say it; empty where it is reliable."""
    if not line.doubt and line.expected_overlap is not None and line.expected_overlap < UNRELIABLE:
        return f"the map's probabilities expect an IoU of {line.expected_overlap:.2f} between its mask and what moves"
    return line.doubt


def write(run, frames, file):
    """The recording of a run. frames: (line, picture, blue green red) in order. Returns how many were written."""
    movers, poses = read_table(read_movers, run.path / "tracks.csv"), read_table(read_poses, run.path / "trajectory.txt")
    count = 0
    with rr.RecordingStream("egosieve") as record:
        record.save(file, default_blueprint=blueprint(bool(poses)))
        record.send_recording_name(run.path.resolve().name)
        log_statics(record, run, movers, poses)
        for line, picture in frames:
            log_frame(record, run, line, picture, movers.get(line.index, []), poses.get(f"{line.time_seconds:.6f}"))
            count += 1
        record.flush()
        record.disconnect()
    return count
