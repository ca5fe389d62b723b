"""The sensor: irradiance to digital numbers, one function per step, in EMVA 1288's symbols.

| step | function | gives |
| --- | --- | --- |
| 1 | `photons` | mu_p, mean photons on a pixel, from irradiance (W m^-2), pixel area, time |
| 2 | `electrons` | mu_e, mean photo-electrons (e-), by the quantum efficiency |
| 3 | `FixedPattern.response` | PRNU and dead pixels: times mu_e |
| 4 | `dark_electrons`, `hot_electrons` | dark current: plus mu_I t (e-), by temperature |
| 5 | `shot_noise` | Poisson numbers of light and dark electrons together (e-) |
| 6 | `FixedPattern.dsnu_e` | DSNU: plus a fixed offset (e-) |
| 7 | `saturate` | the full well clips (e-) |
| 8 | `read_noise` | normal noise sigma_d (e-) |
| 9 | `amplify` | system gain K and black level: DN, not yet whole |
| 9 | `gains` | K of each channel: white balance |
| 9a | `gamma_curve` | gamma other than 1: DN, bent, within the range |
| 10 | `quantise` | rounded once, within 0 .. 2^bits - 1 (DN) |
| 11 | `demosaic` | if there is a mosaic: red green blue of every pixel (DN), rounded again |

`expose` runs them all. Arrays of images are (..., 3), red green blue; the steps work on any shape.

**Where non-uniformity comes in.** EMVA 1288 defines PRNU by its effect, the spread of the mean
response over pixels, and lets temporal variance grow by K for each electron: sigma_y^2 = K^2
(sigma_d^2 + mu_e) + 1/12. So the response varies before the shot noise, like an efficiency: a pixel
that collects more electrons also has more shot noise and lies on the same line. (A gain that
varied would bend it.) DSNU is an offset without shot noise of its own. Dark electrons are electrons
like others: they have shot noise and fill the well.

**The full well** clips electrons after shot noise and DSNU, before read noise. Near it the mean is
less than expected, and the variance falls to that of the read noise.

A rolling shutter is in the light (`simtip.mix`): what is lit, not what is read, differs by row.

Left out: crosstalk, smear, noise that is not white. With a mosaic, gamma acts on the raw values.
"""

from simtip.sensor.chain import expected_dn, expose
from simtip.sensor.dark import dark_electrons, dark_factor, hot_electrons
from simtip.sensor.light import electrons, mean_electrons, photons, responsivity
from simtip.sensor.mosaic import demosaic
from simtip.sensor.pattern import UNIFORM, FixedPattern, fixed_pattern
from simtip.sensor.readout import (
    Image,
    amplify,
    gains,
    gamma_curve,
    linear_dn,
    quantise,
    read_noise,
    saturate,
)
from simtip.sensor.shot import TABLE_BELOW_E, poisson_quantile, shot_noise

__all__ = [
    "TABLE_BELOW_E",
    "UNIFORM",
    "FixedPattern",
    "Image",
    "amplify",
    "dark_electrons",
    "dark_factor",
    "demosaic",
    "electrons",
    "expected_dn",
    "expose",
    "fixed_pattern",
    "gains",
    "gamma_curve",
    "hot_electrons",
    "linear_dn",
    "mean_electrons",
    "photons",
    "poisson_quantile",
    "quantise",
    "read_noise",
    "responsivity",
    "saturate",
    "shot_noise",
]
