"""The 5-DOF manipulator with four SPS limbs and one SPR limb (Wang et al. 2017)."""
