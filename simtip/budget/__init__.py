"""Where every micrometre of error comes from: causes switched off one by one and together.

`causes` names them, `observed` takes the pictures that they need, `tips` says where a detector saw
the tip under any of them, `errors` what error that makes, `shares` how it is split.
"""
