"""The nonlinear soft shell: passive and active tension, kinematics, residual and tangent."""
