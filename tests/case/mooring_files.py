"""Mooring files in the layouts that the documents of MoorDyn, MoorPy and MAP++ show.

All describe one line of 530 m from a fairlead at (5, 0, -10) m to an anchor at (500, 0, -100) m in
water 100 m deep, of 80 kg/m, 0.1 m, 400 MN, in the words and columns of each version.
"""

DOCUMENTED_2 = """\
--------------------- MoorDyn Input File ------------------------------------
MoorDyn v2 sample input file
---------------------- LINE TYPES ------------------------------------------------
TypeName   Diam    Mass/m     EA     BA/-zeta    EI         Cd     Ca     CdAx    CaAx    Cl    dF
(name)     (m)     (kg/m)     (N)    (N-s/-)     (N-m^2)    (-)    (-)    (-)     (-)     (-)   (-)
main       0.1     80.0       400e6  -1          {EI}       1.6    1      1.0     0.5
---------------------- ROD TYPES ------------------------------------
TypeName      Diam     Mass/m    Cd     Ca      CdEnd    CaEnd
(name)        (m)      (kg/m)    (-)    (-)     (-)      (-)
Buoy          10       1.0e3     0.6    1.0     1.2      1.0
---------------------- BODIES ---------------------------------------
ID   Attachment  X0     Y0    Z0     r0      p0     y0     Mass  CG*   I*      Volume   CdA*   Ca*
(#)   (word)     (m)    (m)   (m)   (deg)   (deg)  (deg)   (kg)  (m)  (kg-m^2)  (m^3)   (m^2)  (-)
1     {body}
---------------------- RODS ----------------------------------------
ID   RodType  Attachment  Xa    Ya    Za    Xb    Yb    Zb   NumSegs  RodOutputs
(#)  (name)   (word/ID)   (m)   (m)   (m)   (m)   (m)   (m)  (-)       (-)
---------------------- POINTS ---------------------------------------
ID   Attachment  X       Y     Z      Mass   Volume  CdA    Ca
(#)   (word/ID) (m)     (m)   (m)    (kg)   (m^3)   (m^2)  (-)
1     Fixed      500      0     -100   0      0       0      0      ! the anchor
2     {fairlead}          0      0       0      0
---------------------- LINES ----------------------------------------
ID   LineType   AttachA  AttachB  UnstrLen  NumSegs  LineOutputs
(#)   (name)     (ID)     (ID)      (m)       (-)      (-)
1     main        1        2        530        20       p
---------------------- OPTIONS -----------------------------------------
1             writeLog      Write log file
0.002         dtM           time step to use in mooring integration (s)
3000000       kbot          bottom stiffness (Pa/m)
RK2           tScheme
{options}
0.001         threshIC      threshold for IC convergence (-)
---------------------- OUTPUTS -----------------------------------------
FAIRTEN1
ANCHTEN1
------------------------- need this line -------------------------------------
"""
COUPLED = "Coupled    5        0     -10"
OWN_BODY = (
    "coupled     0     0      0     0       0      0       0     0     0        0       0      0"
)
DEPTH = "100 WtrDpth water depth (m)"


def version_2(
    fairlead: str = COUPLED, body: str = OWN_BODY, options: str = DEPTH, EI: str = "0"
) -> str:
    """The layout of version 2."""
    return DOCUMENTED_2.format(fairlead=fairlead, body=body, options=options, EI=EI)


DOCUMENTED_1 = """\
MoorDyn input file...
MoorDyn v1 sample input file
True          Echo          echo the input file data (flag)
------------------------- LINE TYPES --------------------------------------------------
LineType  Diam    MassDen    EA       BA/-zeta   Can   Cat   Cdn   Cdt
(-)       (m)     (kg/m)     (N)      (Pa-s/-)   (-)   (-)   (-)   (-)
main      0.1     80.0       400.0e6  -0.8       1.0   0.0   1.6   0.05
----------------------- POINT PROPERTIES ----------------------------------------------
Node      Type      X        Y         Z        M        V        FX       FY      FZ     CdA   CA
(-)       (-)      (m)      (m)       (m)      (kg)     (m^3)    (kN)     (kN)    (kN)   (m^2)  (-)
1         Fixed    500.0     0     -100.00       0        0        0        0       0       0     0
2         Vessel     5.0     0      -10.00       0        0        0        0       0       0     0
-------------------------- LINE PROPERTIES -------------------------------------------------
Line     LineType  UnstrLen  NumSegs    NodeAnch  NodeFair  Flags/Outputs
(-)      (-)       (m)         (-)       (-)       (-)      (-)
1        main      530.0        50        1         2        p
-------------------------- SOLVER OPTIONS---------------------------------------------------
0.001    dtM          - time step to use in mooring integration
3.0e6    kb           - bottom stiffness
3.0e5    cb           - bottom damping
100      WtrDpth      - water depth
5.0      ICDfac       - factor by which to scale drag coefficients during dynamic relaxation IC gen
---------------------- OUTPUTS -----------------------------------------
FairTen1
END
------------------------- need this line -------------------------------------
"""
COUNTED_1 = """\
--------------------- MoorDyn Input File ------------------------------------
Mooring system with one line
FALSE    Echo      - echo the input file data (flag)
----------------------- LINE TYPES ------------------------------------------
1        NTypes    - number of LineTypes
Name     Diam      MassDen      EA    BA/-zeta  Can   Cat   Cdn   Cdt
(-)       (m)      (kg/m)       (N)   (N-s/-)   (-)   (-)   (-)   (-)
main     0.1       80.0      4.0D+08  -0.8      1.0   0.0   1.6   0.05
---------------------- CONNECTION PROPERTIES --------------------------------
2       NConnects - number of connections including anchors and fairleads
Node    Type      X        Y        Z       M     V      FX   FY   FZ   CdA   CA
(-)     (-)      (m)      (m)      (m)     (kg)  (m^3)  (kN) (kN) (kN) (m^2)  (-)
1      fixed    500.0      0.0    -100.0    0     0      0    0    0     0     0
2      vessel     5.0      0.0     -10.0    0     0      0    0    0     0     0
---------------------- LINE PROPERTIES --------------------------------------
1        NLines    - number of line objects
Line    LineType  UnstrLen  NumSegs   {ends}  Flags/Outputs
(-)       (-)       (m)       (-)       (-)       (-)         (-)
1         main     530.0      20        1         2            p, -
---------------------- SOLVER OPTIONS ---------------------------------------
0.001    dtM       - time step to use in mooring integration (s)
100.0    WtrDpth   - water depth (m)
60.0     TmaxIC    - max time for ic gen (s)
------------------------- need this line --------------------------------------
"""
MOORPY_YAML = """\
water_depth: 100
rho: 1025.0
line_types:
  - {name: main, diameter: 0.1, mass_density: 80.0, stiffness: 400e6, breaking_load: 7e6, cost: 150,
     transverse_added_mass: 1.0, tangential_added_mass: 0.0, transverse_drag: 1.6,
     tangential_drag: 0.1}
points:
  - {name: anchor1, type: fixed, location: [500, 0, -100], anchor_type: drag_embedment}
  - {name: fairlead1, type: vessel, location: [5, 0, -10]}
lines:
  - {name: 1, endA: anchor1, endB: fairlead1, type: main, length: 530}
anchor_types:
  - {name: drag_embedment, mass: 0}
"""
RAFT_YAML = "settings: {min_freq: 0.001}\nmooring:\n" + "".join(
    f"  {line}\n" for line in MOORPY_YAML.splitlines()
)
MAP = """\
---------------------- LINE DICTIONARY ---------------------------------------
LineType  Diam      MassDenInAir   EA            CB   CIntDamp  Ca   Cdn    Cdt
(-)       (m)       (kg/m)        (N)           (-)   (Pa-s)    (-)  (-)    (-)
main      0.1       80.0          400e6         0.65  1.0E8     0.6  -1.0   0.05
---------------------- NODE PROPERTIES ---------------------------------------
Node  Type       X       Y       Z      M     B     FX      FY      FZ
(-)   (-)       (m)     (m)     (m)    (kg)  (m^3)  (N)     (N)     (N)
1     Fix       500      0      depth   0     0      #       #       #
2     Vessel      5      0      -10     0     0      #       #       #
---------------------- LINE PROPERTIES ---------------------------------------
Line    LineType  UnstrLen  NodeAnch  NodeFair  Flags
(-)      (-)       (m)       (-)       (-)       (-)
1        main      530       1         2
---------------------- SOLVER OPTIONS-----------------------------------------
Option
(-)
help
outer_tol 1e-4
repeat 120 240
"""
