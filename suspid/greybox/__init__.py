"""Springs and dampers straight from a recording, whatever moved the car.

The room for `estimate`, `find_drives` and `damper_curve`: grey-box estimators that fit the parameters of a
`suspid.Suspension` to records under any excitation. Nothing is here yet. An estimator is a module of its name
with a function that takes records and a suspension and returns a frozen result with a ``verdict``.
"""
