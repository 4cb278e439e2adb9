"""The cards of airbag, material, contact and wall keywords: names of their columns in the order of the manual.

Names as in "LS-DYNA Keyword User's Manual", volumes I and II, checked against the field tables of PyDYNA (ansys/pydyna,
MIT licence). A dot is a column that is not used. `TARGETS` says where a field goes in a case; a field without an entry
is named in the report as one that Billow has nothing for, unless it is blank, zero or its `DEFAULTS`.
"""

from __future__ import annotations

CORE = {"core": "SID SIDTYP RBID VSCA PSCA VINI MWD SPSF"}
"""First card of all airbags but PARTICLE and the meshed gases."""
EXITS = "C23 LCC23 A23 LCA23 CP23 {} AP23 LCAP23"
"""The curve of CP23 has two names."""
JET, JET_ENDS = "XJFP YJFP ZJFP XJVH YJVH ZJVH CA BETA", "XSJFP YSJFP ZSJFP PSID ANGLE NODE1 NODE2 NODE3"

CARDS: dict[str, dict[str, str]] = {
    "AIRBAG_SIMPLE_PRESSURE_VOLUME": {**CORE, "gas": "CN BETA LCID LCIDDR"},
    "AIRBAG_SIMPLE_AIRBAG_MODEL": {**CORE, "gas": "CV CP T LCID MU AREA PE RO", "molar": "LOU TEXT A B MW GASC"},
    "AIRBAG_ADIABATIC_GAS_MODEL": {**CORE, "gas": "PSF LCID GAMMA P0 PE RO"},
    "AIRBAG_WANG_NEFSKE": {
        **CORE,
        "gas": "CV CP T LCT LCMT TVOL LCDT IABT",
        "exits": EXITS.format("LCCP23"),
        "ambient": "PE RO GC LCEFR POVER PPOP OPT KNKDN",
        "inflator": "IOC IOA IVOL IRO IT LCBF",
        "molar": "TEXT A B MW GASC HCONV",
        "pop": "TDP AXP AYP AZP AMAGP TDURP TDA RBIDP",
        "jet": JET,
        "many jets": JET.replace("CA", "LCJRV"),
        "jet ends": JET_ENDS,
        "reaction": "NREACT",
    },
    "AIRBAG_HYBRID": {
        **CORE,
        "ambient": "ATMOST ATMOSP ATMOSD GC CC HCONV",
        "exits": EXITS.format("LCP23"),
        "options": "OPT PVENT NGAS LCEFR LCIDM0 VNTOPT",
        "gas": "LCIDM LCIDT . MW INITM A B C",
        "aspirated": "FMASS",
        "jet": JET,
        "jet ends": JET_ENDS,
        "reaction": "NREACT",
    },
    "AIRBAG_PARTICLE": {
        "mpp": "SX SY SZ",
        "time": "BIRTH DEATH",
        "bag": "SID1 STYPE1 SID2 STYPE2 BLOCK NPDATA FRIC IRDP",
        "segment": "SEGSID",
        "particles": "NP UNIT VISFLG TATM PATM NVENT TEND TSW",
        "jet": "JNODE",
        "tracking": "TSTOP TSMTH OCCUP REBL SIDSV PSID1 TSPLIT SFFDC",
        "more tracking": "SFIAIR4 IDFRIC MDNOISE",
        "units": ". MASS . TIME . LENGTH",
        "gases": "IAIR NGAS NORIF NID1 NID2 NID3 CHM CD_EXT",
        "inner part": "SIDUP STYUP PFRAC LINKING",
        "heat": "SIDH STYPEH HCONV PFRIC SDFBLK KP INIP CP",
        "vent": "SID3 STYPE3 C23 LCTC23 LCPC23 ENH_V PPOP",
        "air": "PAIR TAIR XMAIR AAIR BAIR CAIR NPAIR NPRLX",
        "mole fractions": "LCMASS",
        "gas": "LCM LCT XM A B C INFG",
        "orifice": "NID AN VD CA INFO IMOM IANG CHM_ID",
    },
    "DEFINE_CPM_CHAMBER": {
        "head": "ID NCHM",
        "chamber": "SID1 SID2 NINTER CHM_ID",
        "interaction": "SID3 ITYPE3 TOCHM",
    },
    "AIRBAG_ALE": {
        "core": "SID SIDTYP . . . . MWD SPSF",
        "ambient": "ATMOST ATMOSP . GC CC TNKVOL TNKFINP",
        "coupling": "NQUAD CTYPE PFAC FRIC FRCMIN NORMTYP ILEAK PLEAK",
        "vents": "IVSETID IVTYPE IBLOCK VNTCOF",
        "lattice": "NX/IDA NY/IDG NZ MOVERN ZOOM",
        "origin": "X0 Y0 Z0 X1 Y1 Z1",
        "corners": "X2 Y2 Z2 X3 Y3 Z3",
        "flow": "SWTIME . HG NAIR NGAS NORIF LCVEL LCT",
        "air": ". . . MWAIR INITM AIRA AIRB AIRC",
        "gas": "LCMF . . MWGAS . GASA GASB GASC",
        "orifice": "NODEID VECID ORIFARE",
    },
    "AIRBAG_ADVANCED_ALE": {"each": " ".join(f"COLUMN{k}" for k in range(1, 9))},
    "DEFINE_ALEBAG_BAG": {
        "bag": "BAGID SID SIDTYPE CVBAG IBLOCK VCOF VSET VTYPE",
        "coupling": "NQUAD CTYPE PFAC FRIC FRCMIN NORMTYP ILEAK PLEAK",
        "life": "NORM START END",
    },
    "DEFINE_ALEBAG_HOLE": {"hole": "HOLEID SID SIDTYPE NQUAD XOFF NFOLD XCLEN INT/EXT"},
    "DEFINE_ALEBAG_INFLATOR": {
        "inflator": "INFID . . . NGAS NORIF LCVEL LCT",
        "gas": "LCIDM . . MWGAS . GASA GASB GASC",
        "orifice": "NODEID VECID ORIFARE",
    },
    "AIRBAG_INTERACTION": {"interaction": "AB1 AB2 AREA SF PID LCID IFLOW"},
    "MAT_FABRIC": {
        "elastic": "MID RO EA EB . PRBA PRAB .",
        "shear": "GAB . . CSE EL PRL LRATIO DAMP",
        "leakage": "AOPT FLC FAC ELA LNRC FORM FVOPT TSRFAC",
        "yarns": "L R C1 C2 C3",
        "axes": ". RGBRTH A0REF A1 A2 A3 X0 X1",
        "vector": "V1 V2 V3 . . . BETA ISREFG",
        "curves": "LCA LCB LCAB LCUA LCUB LCUAB RL",
        "more curves": "LCAA LCBB H DT . ECOAT SCOAT TCOAT",
    },
    "MAT_ADD_AIRBAG_POROSITY_LEAKAGE": {"leakage": "MID FLC FAC ELA FVOPT X0 X1"},
    "MAT_RIGID": {
        "rigid": "MID RO E PR N COUPLE M ALIAS",
        "constraint": "CMO CON1 CON2",
        "axes": "LCO A2 A3 V1 V2 V3",
    },
    "PART_INERTIA": {
        "inertia": "XC YC ZC TM IRCS NODEID",
        "tensor": "IXX IXY IXZ IYY IYZ IZZ",
        "velocity": "VTX VTY VTZ VRX VRY VRZ",
    },
    "MAT_NULL": {"null": "MID RO PC MU TEROD CEROD YM PR"},
    "CONTACT": {
        "mpp": "IGNORE_MPP BCKT LCBCKT NS2TRK INITITR PARMAX . CPARM8",
        "more mpp": ". CHKSEGS PENSF GRPABLE",
        "sides": "SSID MSID SSTYP MSTYP SBOXID MBOXID SPR MPR",
        "friction": "FS FD DC VC VDC PENCHK BT DT",
        "scales": "SFS SFM SST MST SFST SFMT FSF VSF",
        "A": "SOFT SOFSCL LCIDAB MAXPAR SBOPT DEPTH BSORT FRCFRQ",
        "B": "PENMAX THKOPT SHLTHK SNLOG ISYM I2D3D SLDTHK SLDSTF",
        "C": "IGAP IGNORE DPRFAC DTSTIF EDGEK . FLANGL CID_RCF",
    },
    "RIGIDWALL_PLANAR": {
        "nodes": "NSID NSIDEX BOXID OFFSET BIRTH DEATH RWKSF",
        "wall": "XT YT ZT XH YH ZH FRIC WVEL",
        "orthotropic": "SFRICA SFRICB DFRICA DFRICB DECAYA DECAYB",
        "more orthotropic": "NODE1 NODE2 D1 D2 D3",
        "finite": "XHEV YHEV ZHEV LENL LENM",
        "moving": "MASS V0",
    },
    "RIGIDWALL_GEOMETRIC": {
        "nodes": "NSID NSIDEX BOXID BIRTH DEATH",
        "wall": "XT YT ZT XH YH ZH FRIC",
        "sphere": "RADSPH",
        "cylinder": "RADCYL LENCYL NSEGS",
        "section": "VL HEIGHT",
        "flat": "XHEV YHEV ZHEV LENL LENM",
        "prism": "XHEV YHEV ZHEV LENL LENM LENP",
        "motion": "LCID OPT VX VY VZ",
    },
    "BOUNDARY_PRESCRIBED_MOTION": {
        "motion": "TYPEID DOF VAD LCID SF VID DEATH BIRTH",
        "offset": "OFFSET1 OFFSET2 MRB NODE1 NODE2",
    },
    "LOAD_RIGID_BODY": {"load": "PID DOF LCID SF CID M1 M2 M3"},
    "BOUNDARY_SPC": {"spc": "NID CID DOFX DOFY DOFZ DOFRX DOFRY DOFRZ", "life": "BIRTH DEATH"},
    "CONSTRAINED_EXTRA_NODES": {"extra": "PID NID IFLAG"},
    "INITIAL_VELOCITY": {
        "set": "NSID NSIDEX BOXID IRIGID ICID",
        "velocity": "VX VY VZ VXR VYR VZR",
        "exempted": "VXE VYE VZE VXRE VYRE VZRE",
    },
    "INITIAL_VELOCITY_NODE": {"velocity": "NID VX VY VZ VXR VYR VZR ICID"},
    "INITIAL_VELOCITY_GENERATION": {
        "velocity": "ID STYP OMEGA VX VY VZ IVATN ICID",
        "axis": "XC YC ZC NX NY NZ PHASE IRIGID",
    },
    "INITIAL_VELOCITY_RIGID_BODY": {"velocity": "PID VX VY VZ VXR VYR VZR ICID"},
    "CONTROL_TERMINATION": {"termination": "ENDTIM ENDCYC DTMIN ENDENG ENDMAS NOSOL"},
    "DATABASE_BINARY_D3PLOT": {"interval": "DT LCDT BEAM NPLTC PSETID"},
    "DATABASE_ABSTAT": {"interval": "DT BINARY LCUR IOOPT"},
    "LOAD_BODY": {"load": "LCID SF LCIDDR XC YC ZC CID"},
}
"""Keyword -> card -> columns. Those of *AIRBAG_ADVANCED_ALE are not known: it is read by what it names."""

ALIASES = {
    "MAT_034": "MAT_FABRIC", "MAT_34": "MAT_FABRIC", "MAT_020": "MAT_RIGID", "MAT_20": "MAT_RIGID",
    "MAT_009": "MAT_NULL", "MAT_9": "MAT_NULL",
}  # fmt: skip
"""Other names of keywords."""

TARGETS = {
    "ATMOST": "ambient.temperature", "ATMOSP": "ambient.pressure", "GC": "units", "HCONV": "gas.heat_transfer",
    "SID": "bag.parts", "SIDTYP": "bag.parts", "SID1": "bag.parts", "STYPE1": "bag.parts",
    "C23": "discharge", "LCC23": "discharge", "A23": "gas.orifices.exit.area", "CP23": "discharge",
    "LCCP23": "discharge", "LCP23": "discharge", "AP23": "gas.orifices.porosity.area",
    "PVENT": "bag.vents.opening_pressure",
    "LCIDM": "inflator.mass_flow", "LCIDT": "inflator.temperature", "MW": "gas.species.molar_mass",
    "INITM": "gas.initial.gas", "A": "gas.species.a", "B": "gas.species.b", "C": "gas.species.c",
    "CV": "gas.species.a", "CP": "gas.species.a", "T": "inflator.temperature", "LCT": "inflator.temperature",
    "LCMT": "inflator.mass_flow", "LCID": "inflator.mass_flow", "MU": "gas.orifices.exit.discharge",
    "AREA": "gas.orifices.exit.area", "PE": "ambient.pressure", "RO": "fabric.density",
    "EA": "fabric.young_warp", "EB": "fabric.young_weft", "PRBA": "fabric.poisson", "PRAB": "fabric.poisson",
    "GAB": "fabric.shear", "CSE": "fabric.compression", "DAMP": "fabric.damping", "EL": "fabric.liner.young",
    "PRL": "fabric.liner.poisson", "LRATIO": "fabric.liner.ratio", "FLC": "leakage.time_factor",
    "FAC": "leakage.pressure_factor", "ELA": "leakage.through_blocked", "FVOPT": "leakage.law",
    "FORM": "fabric.law", "RGBRTH": "bag.birth_time", "BETA": "bag.parts.warp_angle",
    "AOPT": "bag.parts.warp_angle", "ISREFG": "bag.reference", "LCA": "fabric.curves.warp.loading",
    "LCB": "fabric.curves.weft.loading", "LCAB": "fabric.curves.shear.loading",
    "LCUA": "fabric.curves.warp.unloading", "LCUB": "fabric.curves.weft.unloading",
    "LCUAB": "fabric.curves.shear.unloading", "TCOAT": "fabric.coating.thickness", "X0": "leakage.area",
    "X1": "leakage.area", "NP": "gas.particles", "UNIT": "units", "TATM": "ambient.temperature",
    "PATM": "ambient.pressure", "TSW": "gas.switch_time", "PAIR": "gas.initial.pressure",
    "TAIR": "gas.initial.temperature", "XMAIR": "gas.species.molar_mass", "AAIR": "gas.species.a",
    "BAIR": "gas.species.b", "CAIR": "gas.species.c", "LCM": "inflator.mass_flow", "XM": "gas.species.molar_mass",
    "NID": "inflator.jets", "AN": "inflator.jets.hole_diameter", "VD": "inflator.jets.angle",
    "CA": "inflator.jets.cone", "INFG": "inflator.jets", "INFO": "inflator.jets", "LCMASS": "inflator.mass_flow",
    "SID3": "bag.parts",
    "STYPE3": "bag.parts", "LCTC23": "bag.vents.discharge", "PPOP": "bag.vents.opening_pressure",
    "FS": "friction", "ENDTIM": "run.end_time", "DT": "run.frames", "FRIC": "obstacles.friction",
    "AB1": "gas.orifices.between", "AB2": "gas.orifices.between", "SF": "gas.orifices.discharge",
    "BLOCK": "bag.vents.blockage", "IBLOCK": "bag.vents.blockage", "IVSETID": "bag.parts", "IVTYPE": "bag.parts",
    "VNTCOF": "bag.vents.discharge", "NZ": "gas.cell", "SWTIME": "gas.switch_time", "LCMF": "inflator.mass_flow",
    "MWAIR": "gas.species.molar_mass", "AIRA": "gas.species.a", "AIRB": "gas.species.b", "AIRC": "gas.species.c",
    "MWGAS": "gas.species.molar_mass", "GASA": "gas.species.a", "GASB": "gas.species.b", "GASC": "gas.species.c",
    "NODEID": "inflator.jets", "VECID": "inflator.jets.angle", "ORIFARE": "inflator.jets.hole_diameter",
    "GAMMA": "gas.species.a", "P0": "gas.initial.pressure", "CN": "gas.initial.pressure",
    "POVER": "gas.initial.pressure",
}  # fmt: skip
"""Field -> key of a case, as the page of decks lists it; reports say it for each deck."""

DEFAULTS = {
    "VSCA": 1.0, "PSCA": 1.0, "CC": 1.0, "SFS": 1.0, "SFM": 1.0, "SFST": 1.0, "SFMT": 1.0, "FSF": 1.0, "VSF": 1.0,
    "BT": 0.0, "DT": 1e20, "VISFLG": 1.0, "TEND": 1e10, "TSW": 1e10, "TSTOP": 1e11, "TSMTH": 1.0, "OCCUP": 0.1,
    "SFFDC": 1.0, "SFIAIR4": 1.0, "TSRFAC": 0.0, "DEATH": 1e20, "BCKT": 200.0, "NS2TRK": 3.0, "INITITR": 2.0,
    "PARMAX": 1.0005, "PENSF": 1.0, "RL": 0.0, "CA": 30.0, "SDFBLK": 1.0, "PSF": 1.0,
}  # fmt: skip
"""Values that mean the same as a blank field."""


def known(name: str) -> str | None:
    """The entry of CARDS of a keyword with its options, or None."""
    plain = name
    for alias, meant in ALIASES.items():
        if plain == alias or plain.startswith(alias + "_"):
            plain = meant + plain[len(alias) :]
    return max((key for key in CARDS if plain == key or plain.startswith(key + "_")), key=len, default=None)
