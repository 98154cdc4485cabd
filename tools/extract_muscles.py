"""Reads the muscle paths of `myo-sim`'s arm and writes `posture_ik/muscle/data/arm_paths.csv`.

    pip install mujoco myo-sim && python tools/extract_muscles.py

The model is the one of `extract_arm.py`: the MyoArm of myo-sim (Apache-2.0), a MuJoCo rendering of
the upper limb of Saul et al. (2014) and Holzbaur et al. (2005). A path is a row of points and of
the spheres and cylinders between them; each is given in the frame of the link it is fixed to, the
hand being one link. Of myo-sim's numbers on forces and lengths none is read: they are normalised
by length ranges that several paths do not keep to, and its SUPSP carries SUP's gain; those numbers
stand in `arm_muscles.csv`, after the publications themselves.

What is left out of the paths, and why, is `LEFT_OUT`; nothing else is changed.
"""

from __future__ import annotations

import csv
from importlib.metadata import version
from pathlib import Path
from typing import Any

import extract_arm
import mujoco
import numpy as np

#: A posture at which every cylinder that is kept is touched, deg: from it is read which way round.
TOUCHED = {
    "elv_angle_r": 26.5,
    "shoulder_elv_r": 93.0,
    "shoulder_rot_r": -132.0,
    "elbow_flexion_r": 5.0,
    "pro_sup_r": -85.0,
}

MUSCLES = (
    *("DELT1", "DELT2", "DELT3", "SUPSP", "INFSP", "SUBSC", "TMIN", "TMAJ", "PECM1", "LAT1"),
    *("CORB", "TRIlong", "TRIlat", "TRImed", "BIClong", "BICshort", "BRA", "BRD", "SUP", "PT"),
    *("ECRL", "ECRB", "ECU", "FCR", "FCU"),
)
_UNTOUCHED = "not touched anywhere in the range of arm_range.csv"
_BEHIND = "not touched in the range: the muscle passes behind while the elbow's cylinder lies ahead"
#: Element of myo-sim that is not taken, by muscle, and the reason.
LEFT_OUT = {
    ("TRIlong", "TRIlong_TRIlong-P1b_r"): (
        "lies beside P1 but on the humerus: tied so close to the scapula, turning the humerus "
        "lengthens the muscle by a false 42 mm a radian"
    ),
    ("DELT2", "delt2hum_cylinder"): "never touched: both points beside it are on the humerus",
    ("DELT3", "Delt3_torus"): "never touched: both points beside it are on the scapula",
    ("INFSP", "infsp_new_cylinder"): (
        "never touched: P1 lies 0.03 mm inside it, where MuJoCo wraps nothing"
    ),
    ("CORB", "TMAJ_LAT_PEC_CORBhh_sphere"): _UNTOUCHED,
    ("BICshort", "Elbow_BIC_BRD_ellipsoid_BICshort"): _UNTOUCHED,
    ("TRIlong", "TRI_cylinder"): _BEHIND,
    ("TRIlat", "TRI_cylinder"): _BEHIND,
    ("TRImed", "TRI_cylinder"): _BEHIND,
}
#: What is kept as it is there though it may be wrong, by muscle.
DOUBTFUL = {
    "BRD": (
        "bowstrings between its points as the elbow closes: its flexion arm passes 90 mm at 124 "
        "deg, where a published polynomial fit to cadavers has 70 mm"
    ),
    "DELT2": (
        "has its side point 1 mm inside its sphere, so that it runs through it as through a ring, "
        "though the element is named an ellipsoid: with the arm hanging it does not abduct (arm "
        "-3 mm; 20 mm at 60 deg); run over, its arms would differ by 9 mm RMS, 30 mm at worst"
    ),
    "DELT3": "runs through a ring too; run over, its arms would differ by 1 mm RMS, 4 mm at worst",
    "PECM1": "runs through a ring too; run over, its arms would differ by 4 mm RMS, 9 mm at worst",
    "INFSP": "runs straight, its cylinder being out of use; its arms have the signs of anatomy",
}
#: Middle of the angles by which a path turns about a cylinder over the range, deg; elsewhere 180.
TURNS = {("LAT1", "delt2hum_cylinder"): 0.0, ("SUP", "SUP_cylinder"): 240.0}
COLUMNS = "element,muscle,kind,link,x_m,y_m,z_m,radius_m,axis_x,axis_y,axis_z,turn_deg"
WHAT = (
    "muscle paths, each element in the frame of its link and in the path's order; the path runs "
    "over an outside body and through an inside one, and turns positively about a cylinder's axis, "
    "by turn_deg give or take less than half a turn"
)


def links(model: Any) -> dict[int, str]:
    """The link of ours that each body of theirs is fixed to, by the body's number."""
    known = {model.body("lunate_r").id: "hand"}
    known |= {model.body(body).id: link for link, body in extract_arm.BODIES.items()}
    known |= {model.body(body).id: link for link, body in extract_arm.FRAMES.items()}
    for i in range(model.nbody):
        if i not in known and not model.body_jntnum[i] and model.body_parentid[i] in known:
            known[i] = known[model.body_parentid[i]]
    return known


def paths(model: Any, state: Any) -> list[list[Any]]:
    """A row for each element of each path, in order."""
    for joint, angle in TOUCHED.items():
        state.joint(joint).qpos[0] = np.radians(angle)
    mujoco.mj_kinematics(model, state)
    mujoco.mj_comPos(model, state)
    mujoco.mj_tendon(model, state)
    link_of = links(model)
    bodies = {**extract_arm.BODIES, **extract_arm.FRAMES}

    def local(body: int, point: np.ndarray, axis: np.ndarray) -> tuple[str, np.ndarray, np.ndarray]:
        link = link_of[body]
        on = state.body(bodies[link])
        R = on.xmat.reshape(3, 3).T
        return link, R @ (point - on.xpos), R @ axis

    rows: list[list[Any]] = []
    for muscle in MUSCLES:
        tendon = model.tendon(f"{muscle}_tendon").id
        first = model.tendon_adr[tendon]
        count = 0
        for k in range(first, first + model.tendon_num[tendon]):
            i = model.wrap_objid[k]
            if model.wrap_type[k] == mujoco.mjtWrap.mjWRAP_SITE:
                site = model.site(i)
                if (muscle, site.name) in LEFT_OUT:
                    continue
                count += 1
                link, point, _ = local(site.bodyid[0], state.site_xpos[i], np.zeros(3))
                rows.append([f"{muscle}-{count}", muscle, "point", link, *point, *[""] * 5])
                continue
            geom = model.geom(i)
            if (muscle, geom.name) in LEFT_OUT:
                continue
            kind, axis = _shape(model, state, tendon, k)
            link, point, axis = local(geom.bodyid[0], state.geom_xpos[i], axis)
            shown = [""] * 4
            if kind == "cylinder":
                shown = [*axis, TURNS.get((muscle, geom.name), 180.0)]
            element = f"{muscle}-{count}-{count + 1}"
            rows.append([element, muscle, kind, link, *point, geom.size[0], *shown])
    return rows


def _shape(model: Any, state: Any, tendon: int, k: int) -> tuple[str, np.ndarray]:
    """How the path meets a body: `inside`, `outside`, or `cylinder` about an axis in the world."""
    i = model.wrap_objid[k]
    axes, centre = state.geom_xmat[i].reshape(3, 3), state.geom_xpos[i]
    if model.wrap_type[k] == mujoco.mjtWrap.mjWRAP_SPHERE:
        side = int(model.wrap_prm[k])
        within = side >= 0 and (
            np.linalg.norm(state.site_xpos[side] - centre) < model.geom(i).size[0]
        )
        return "inside" if within else "outside", axes[:, 2]
    start = state.ten_wrapadr[tendon]
    part = slice(start, start + state.ten_wrapnum[tendon])
    on = state.wrap_obj.ravel()[part] == i
    if not on.any():
        raise RuntimeError(f"{model.geom(i).name} is not touched at {TOUCHED}")
    touch = axes.T @ (state.wrap_xpos.reshape(-1, 3)[part][on][0] - centre)
    before = axes.T @ (state.site_xpos[model.wrap_objid[k - 1]] - centre)
    # From a point outside, the path first turns by less than 90 deg, so that the sign tells.
    turn = np.sign(before[0] * touch[1] - before[1] * touch[0])
    return "cylinder", turn * axes[:, 2]


def main() -> None:
    """Write the table."""
    model, state = extract_arm.build()
    room = Path(__file__).resolve().parents[1] / "posture_ik" / "muscle" / "data"
    with (room / "arm_paths.csv").open("w", newline="") as file:
        provenance = extract_arm.PROVENANCE.format(version("myo-sim"))
        provenance = provenance.replace("extract_arm", "extract_muscles")
        file.write(f"# {provenance}; {WHAT}\n")
        for (muscle, element), why in LEFT_OUT.items():
            file.write(f"# left out of {muscle}: {element}, {why}\n")
        file.write(f"{COLUMNS}\n")
        csv.writer(file, lineterminator="\n").writerows(extract_arm.text(paths(model, state)))


if __name__ == "__main__":
    main()
