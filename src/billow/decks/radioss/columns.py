"""The cards of Radioss' keywords: names of their columns, 10 characters wide, or as many as stand behind a colon.

From the Altair Radioss reference guide, and the formats of OpenRadioss' reader (hm_cfg_files); a dot is a column that
is not used.
"""

from __future__ import annotations

from billow.decks.cards import Cards, Field
from billow.decks.context import Context

SCALES = "Ascalet:20 AscaleP:20 AscaleS:20 AscaleA:20 AscaleD:20"
FACTORS = "fct_IDt fct_IDP fct_IDA . Fscalet:20 FscaleP:20 FscaleA:20"
MOTION = "fct_IDT Dir skew_ID sens_ID grnd_ID frame_ID Icoor"
SCALES_OF_MOTION = "Ascale_x:20 Fscale_y:20 Tstart:20 Tstop:20"

CARDS: dict[str, dict[str, str]] = {
    "MONVOL/AIRBAG1": {
        "surface": "surf_IDex . Hconv:20",
        "scales": SCALES,
        "gas": "mat_ID . Mu:20 Pext:20 T0:20 Iequil Ittf",
        "injectors": "Njet",
        "injector": "inject_ID sens_ID Ijet node_ID1 node_ID2 node_ID3",
        "jet": "fct_IDPt fct_IDPtheta fct_IDPdelta . FscalePt:20 FscalePtheta:20 FscalePdelta:20",
        "holes": "Nvent Nporsurf",
        "vent": "surf_IDv Iform Avent:20 Bvent:20 .:20 vent_title:20",
        "opening": "Tstart:20 Tstop:20 dPdef:20 dtPdef:20 . IdtPdef",
        "factors": FACTORS,
        "blocked": FACTORS,
        "velocity": "fct_IDv . Fscalev:20",
        "porous": "surf_IDps Iformps Iblockage .:50 surface_title:20",
        "porosity": "Cps:20 Areaps:20 fct_IDcps fct_IDaps Fscalecps:20 Fscaleaps:20",
    },
    "MONVOL/COMMU1": {
        "bags": "Nbag",
        "bag": "bag_ID surf_IDc dPCdef:20 Acom:20 Tcom:20 dtPCdef:20",
        "area": "fct_IDCt fct_IDCP .:20 FscaleCt:20 FscaleCP:20",
    },
    "MAT/GAS": {
        "mass": "MW:20",
        "heat": "Cpa:20 Cpb:20 Cpc:20 Cpd:20 Cpe:20",
        "more": "Cpf:20",
        "constant": "Cp:20 Cv:20",
        "name": "Gas",
    },
    "PROP/INJECT1": {
        "injector": "N_gases Iflow Ascale_T:20",
        "gas": "Mat_ID fun_ID_M fun_ID_T . Fscale_M:20 Fscale_T:20",
    },
    "MAT/LAW19": {
        "density": "rho_i:20 rho_0:20",
        "moduli": "E11:20 E22:20 nu12:20",
        "shear": "G12:20 G23:20 G31:20",
        "rest": "R_E:20 .:20 ZeroStress:20 Fscale_Por:20 sens_ID",
    },
    "MAT/LAW58": {
        "density": "rho_i:20 rho_0:20",
        "moduli": "E1:20 B1:20 E2:20 B2:20 Flex:20",
        "shear": "G0:20 GT:20 AlphaT:20 Gsh:20 . sens_ID",
        "damping": "Df:20 Ds:20 Gfrot:20 .:20 ZeroStress:20",
        "yarns": "N1 N2 S1:20 S2:20 Flex1:20 Flex2:20",
        "warp": "fct_ID1 . Fscale1:20",
        "weft": "fct_ID2 . Fscale2:20",
        "angle": "fct_ID3 . Fscale3:20",
        "unloading": "fct_ID4 fct_ID5 Fscale4:20 Fscale5:20 fct_ID6 Fscale6:20",
    },
    "PROP": {
        "flags": "Ishell Ismstr Ish3n Idrill",
        "hourglass": "Hm:20 Hf:20 Hr:20 Dm:20 Dn:20",
        "thickness": "N Istrain Thick:20 Ashear:20 Iskew Ithick Iplas",
        "direction": "Vx:20 Vy:20 Vz:20 Phi:20",
        "fabric direction": "Vx:20 Vy:20 Vz:20 skew_ID Ipos . Ip",
        "layer": "Phi_1:20 alpha_1:20 t_1:20 Z_1:20 mat_ID_1",
    },
    "INTER": {
        "sides": "ids_s surf_IDm Istf Ithe Igap Iedge Ibag Idel Icurv Iadm",
        "gap": "Fscalegap:20 Gap_max:20",
        "stiffness": "Stmin:20 Stmax:20",
        "curvature": "node_ID1 node_ID2",
        "friction": "Stfac:20 Fric:20 Gapmin:20 Tstart:20 Tstop:20",
    },
    "RWALL": {
        "nodes": "node_ID Slide grnd_ID1 grnd_ID2",
        "wall": "Dsearch:20 fric:20 Diameter:20 ffac:20 ifq",
        "M": "XM:20 YM:20 ZM:20",
        "M1": "XM1:20 YM1:20 ZM1:20",
        "M2": "XM2:20 YM2:20 ZM2:20",
    },
    "RBODY": {
        "body": "node_ID sens_ID Skew_ID Ispher Mass:20 grnd_ID Ikrem ICoG surf_ID",
        "moments": "Jxx:20 Jyy:20 Jzz:20",
        "products": "Jxy:20 Jyz:20 Jxz:20",
    },
    "IMPDISP": {"motion": MOTION, "scales": SCALES_OF_MOTION},
    "IMPVEL": {"motion": MOTION, "scales": SCALES_OF_MOTION},
    "IMPACC": {"motion": MOTION, "scales": SCALES_OF_MOTION},
    "INIVEL/TRA": {"velocity": "Vx:20 Vy:20 Vz:20 grnd_ID skew_ID", "start": "Tstart:20 sens_ID"},
    "INIVEL/AXIS": {
        "axis": "Dir frame_ID grnd_ID",
        "velocity": "Vxt:20 Vyt:20 Vzt:20 Vr:20",
        "start": "Tstart:20 sens_ID",
    },
    "BCS": {"bcs": "Trarot skew_ID grnd_ID"},
    "GRAV": {"gravity": "fct_IDT Dir skew_ID sens_ID grnd_ID . Ascale_x:20 Fscale_y:20"},
    "SENSOR/TIME": {"sensor": "Tdelay:20"},
}
"""Keyword -> card -> columns."""

TARGETS = {
    "Mass": "obstacles.mass", "Jxx": "obstacles.inertia", "Jyy": "obstacles.inertia", "Jzz": "obstacles.inertia",
    "Jxy": "obstacles.inertia", "Jyz": "obstacles.inertia", "Jxz": "obstacles.inertia",
    "surf_IDex": "bag.parts", "Hconv": "gas.heat_transfer", "mat_ID": "gas.initial.gas", "Pext": "ambient.pressure",
    "T0": "gas.initial.temperature", "inject_ID": "inflator", "sens_ID": "inflator.delay", "surf_IDv": "bag.parts",
    "Avent": "bag.vents.discharge", "Bvent": "bag.vents.through_blocked", "Tstart": "bag.vents.burst_time",
    "dPdef": "bag.vents.opening_pressure", "fct_IDt": "bag.vents.discharge", "fct_IDP": "bag.vents.area_factor",
    "Areaps": "gas.orifices", "Cps": "gas.orifices", "MW": "gas.species.molar_mass", "Cpa": "gas.species.a",
    "Cpb": "gas.species.b", "Cpc": "gas.species.c", "Cp": "gas.species.a", "Cv": "gas.species.a",
    "Mat_ID": "inflator.gas", "fun_ID_M": "inflator.mass_flow", "fun_ID_T": "inflator.temperature",
    "Acom": "gas.orifices.area", "surf_IDc": "bag.parts", "bag_ID": "gas.orifices.between",
    "rho_i": "fabric.density", "E11": "fabric.young_warp", "E22": "fabric.young_weft", "nu12": "fabric.poisson",
    "G12": "fabric.shear", "R_E": "fabric.compression", "E1": "fabric.young_warp", "E2": "fabric.young_weft",
    "G0": "fabric.shear", "fct_ID1": "fabric.curves.warp.loading", "fct_ID2": "fabric.curves.weft.loading",
    "fct_ID3": "fabric.curves.shear.loading", "fct_ID4": "fabric.curves.warp.unloading",
    "fct_ID5": "fabric.curves.weft.unloading", "fct_ID6": "fabric.curves.shear.unloading", "Thick": "fabric.thickness",
    "Phi": "bag.parts.warp_angle", "Fric": "friction", "fric": "obstacles.friction", "Trarot": "bag.fixed_nodes",
    "fct_IDT": "run.gravity",
}  # fmt: skip
"""Field -> key of a case."""


def card(
    context: Context, cards: Cards, keyword: str, name: str, part: str = "", optional: bool = False
) -> dict[str, Field]:
    """A card of CARDS; all its fields will be in the report."""
    names, widths = columns(CARDS[keyword][name])
    read = cards.optional if optional else cards.card
    found = read(name, names, part, widths)
    context.report.take(found.values())
    return found


def columns(text: str) -> tuple[str, tuple[int, ...]]:
    """Names, and widths."""
    pairs = [word.partition(":") for word in text.split()]
    return " ".join(name for name, _, _ in pairs), tuple(int(width or 10) for _, _, width in pairs)
