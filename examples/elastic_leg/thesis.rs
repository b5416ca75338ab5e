//! Tables 8.1 and 8.2 as printed: what was estimated on the real leg.

/// Table 8.1: joint, parameter, estimate, standard deviation.
pub const DRIVES: [(&str, &str, f64, f64); 9] = [
    ("right_hip_pitch", "viscous_friction", 0.00008, 0.0000045),
    ("right_hip_pitch", "coulomb_friction", 0.00456, 0.0000745),
    ("right_hip_pitch", "spring_stiffness", 83008.0, 131.0),
    ("right_knee_pitch", "viscous_friction", 0.00008, 0.0000021),
    ("right_knee_pitch", "coulomb_friction", 0.00268, 0.0001168),
    ("right_knee_pitch", "spring_stiffness", 59966.0, 90.0),
    ("right_ankle_pitch", "viscous_friction", 0.00004, 0.0000227),
    ("right_ankle_pitch", "coulomb_friction", 0.01178, 0.0004170),
    ("right_ankle_pitch", "spring_stiffness", 51394.0, 801.0),
];

/// Table 8.2, the last four rows: friction of the stiff drives.
pub const STIFF: [(&str, &str, f64, f64); 4] = [
    ("right_hip_yaw", "viscous_friction", 0.00004, 0.00002),
    ("right_hip_yaw", "coulomb_friction", 0.00861, 0.00023),
    ("right_hip_roll", "viscous_friction", 0.00042, 0.00004),
    ("right_hip_roll", "coulomb_friction", 0.02167, 0.00103),
];

/// Table 8.2, the load side: combination as printed, estimate, standard deviation.
pub const BODIES: [(&str, f64, f64); 14] = [
    ("c6x² m6 + l11z² (m5 + m4 + c3z m3 / l9y)", 0.01942, 0.15698),
    ("c6x m6 + l11z (m5 + m4 + c3z m3 / l9y)", 0.90143, 0.01490),
    ("m6 + m5 + m4 + c3z m3 / l9y", 1.31041, 0.11251),
    ("m5 c5x² + l10z² m4 + l10z² c3z m3 / l9y", 0.05399, 0.16661),
    ("m5 c5x + l10z m4 + l10z c3z m3 / l9y", 0.76691, 0.01017),
    ("c4x m4 + l9z² c3z m3 / l9y", -0.25609, 0.10250),
    ("c4x m4 + l9z c3z m3 / l9y", -0.14063, 0.02693),
    ("c3z² m3 - l9y c3z m3", -0.04169, 0.05321),
    ("m3 - c3z m3 / l9y", 13.17218, 0.53670),
    ("I6y", 0.04489, 0.16541),
    ("I5z", 0.09691, 0.17372),
    ("I4z", 0.14063, 0.10245),
    ("I2y", 0.01008, 0.03265),
    ("I3y", 0.28832, 0.14656),
];
