"""The shipped cells once more, in Myokit's syntax and written by hand: what `cells.py` compares with.

Corrias & Buist 2007 and Du 2013 are in the units of their sources (pA, nS, pF), the others per area.
"""

HODGKIN_HUXLEY = """
[[model]]
cell.V = -60
cell.m = 0.2
cell.h = 0.2
cell.n = 0.2
[cell]
time = 0 [ms] bind time
stimulus = 10
m_in = 0.1 * (V + 40) / (1 - exp(-(V + 40) / 10))
m_out = 4 * exp(-(V + 65) / 18)
dot(m) = m_in * (1 - m) - m_out * m
dot(h) = 0.07 * exp(-(V + 65) / 20) * (1 - h) - h / (1 + exp(-(V + 35) / 10))
n_in = 0.01 * (V + 55) / (1 - exp(-(V + 55) / 10))
dot(n) = n_in * (1 - n) - 0.125 * exp(-(V + 65) / 80) * n
dot(V) = stimulus - 120 * m^3 * h * (V - 50) - 36 * n^4 * (V + 77) - 0.3 * (V + 54.387)
"""

MORRIS_LECAR = """
[[model]]
cell.V = -60
cell.w = 0.2
[cell]
time = 0 [ms] bind time
stimulus = 100
a = (V + 1.2) / 18
b = (V - 2) / 30
tanh_a = (exp(2 * a) - 1) / (exp(2 * a) + 1)
tanh_b = (exp(2 * b) - 1) / (exp(2 * b) + 1)
dot(w) = 0.04 * (exp(b / 2) + exp(-b / 2)) / 2 * ((1 + tanh_b) / 2 - w)
dot(V) = (stimulus - 2.2 * (1 + tanh_a) * (V - 120) - 8 * w * (V + 84) - 2 * (V + 60)) / 20
"""

PLANT = """
[[model]]
cell.V = {V!r}
cell.h = {h!r}
cell.n = {n!r}
cell.x = {x!r}
cell.c = {c!r}
[cell]
time = 0 [ms] bind time
stimulus = {stimulus!r}
rate = {kinetics_rate!r}
U = (127 * V + 8265) / 105
m_in = 0.1 * (50 - U) / (exp((50 - U) / 10) - 1)
m = m_in / (m_in + 4 * exp((25 - U) / 18))
h_in = 0.07 * exp((25 - U) / 20)
h_out = 1 / (1 + exp((55 - U) / 10))
n_in = 0.01 * (55 - U) / (exp((55 - U) / 10) - 1)
n_out = 0.125 * exp((45 - U) / 80)
dot(h) = rate * (h_in * (1 - h) - h_out * h) / {gate_time_factor!r}
dot(n) = rate * (n_in * (1 - n) - n_out * n) / {gate_time_factor!r}
dot(x) = rate * (1 / (1 + exp(-0.15 * (V + 50))) - x) / {slow_gate_time!r}
dot(c) = rate * {calcium_rate!r} * ({calcium_influx!r} * x * ({calcium_entry_potential!r} - V) - c)
i_inward = ({fast_calcium!r} * m^3 * h + {slow_calcium!r} * x) * (V - {calcium_reversal!r})
g_outward = {potassium!r} * n^4 + {calcium_potassium!r} * c / ({calcium_half_saturation!r} + c)
i_ion = i_inward + g_outward * (V - {potassium_reversal!r}) + {leak!r} * (V - {chloride_reversal!r})
dot(V) = (stimulus - rate * i_ion) / {capacitance!r}
"""

DU_2013 = """
[[model]]
icc.V = -70.0328
icc.d = 0
icc.f = 0.9998
icc.Ca = 0.38498
icc.store = 2.46238
icc.IP3 = 0.4778
[icc]
time = 0 [ms] bind time
dot(d) = (1 / (1 + exp(-(V + 7) / 5)) - d) / 10
dot(f) = (1 / (1 + exp((V + 37.4) / 4)) - f) / 110
inflow = 0.00022 + 0.0002266 * IP3
uptake = 0.00334 * Ca^1.8 / (1 + Ca^1.8)
release = 0.44 * Ca^4 / (1 + Ca^4) * store^4 / (2^4 + store^4) * IP3^4 / (0.65^4 + IP3^4)
dot(Ca) = inflow - uptake + release + 6e-5 * store - 0.00066 * Ca
dot(store) = uptake - release - 6e-5 * store
by_voltage = 0.032 * (1 - V^8 / (60^8 + V^8))
dot(IP3) = 6.2e-5 - 0.02021 * IP3 - 0.00016 * IP3^4 / (0.5^4 + IP3^4) + by_voltage
I_Na = 8 * d * f * (V - 80)
I_Ca = 4 * Ca^4 / (1.4^4 + Ca^4) * (V + 20)
I_BK = 1.2 / (1 + exp(-V / 17 - 2 * log(Ca / 0.001))) * (V + 72)
dot(V) = -(I_Na + I_Ca + I_BK) / 27
"""

CORRIAS_BUIST_2007 = """
[[model]]
smc.V = -69.75
smc.dL = 0
smc.fL = 0.95
smc.dT = 0.02
smc.fT = 0.99
smc.xr1 = 0
smc.xr2 = 0.82
smc.m = 0.005
smc.h = 0.05787
smc.xa1 = 0.00414
smc.xa2 = 0.72
smc.ns = 0
smc.fCa = 1
smc.Ca = 0.00008
[smc]
time = 0 [ms] bind time
qCa = 2.1^1.3
qK = 1.365^1.3
qNa = 2.45^1.3
dot(dL) = (1 / (1 + exp(-(V + 17) / 4.3)) - dL) / (0.47 * qCa)
dot(fL) = (1 / (1 + exp((V + 43) / 8.9)) - fL) / (86 * qCa)
dot(dT) = (1 / (1 + exp(-(V + 27.5) / 10.9)) - dT) / (3 * qCa)
dot(fT) = (1 / (1 + exp((V + 15.8) / 7)) - fT) / (7.58 * exp(0.00817 * V) * qCa)
dot(fCa) = (1 - 1 / (1 + exp(-(Ca - 0.00008999 - 0.000214) / 0.0000131)) - fCa) / (2 * qCa)
dot(xr1) = (1 / (1 + exp(-(V + 27) / 5)) - xr1) / (80 * qK)
dot(xr2) = (0.2 + 0.8 / (1 + exp((V + 58) / 10)) - xr2) / ((-707 + 1481 * exp((V + 36) / 95)) * qK)
dot(m) = (1 / (1 + exp(-(V + 47) / 4.8)) - m) / ((0.44 - 0.017 * V) * qNa)
dot(h) = (1 / (1 + exp((V + 78) / 3)) - h) / ((5.5 - 0.25 * V) * qNa)
dot(xa1) = (1 / (1 + exp(-(V + 26.5) / 7.9)) - xa1) / ((31.8 + 175 * exp(-0.5 * ((V + 44.4) / 22.3)^2)) * qK)
dot(xa2) = (0.1 + 0.9 / (1 + exp((V + 65) / 6.2)) - xa2) / (90 * qK)
dot(ns) = (1 / (1 + exp(-(V + 25) / 20)) - ns) * (1 + exp(-(V + 66) / 26)) / 150
RTF = 8314.4 * 310 / 96486
E_K = RTF * log(5.9 / 164)
E_Ca = RTF / 2 * log(2.5 / Ca)
I_Ca = (65 * dL * fL * fCa + 0.18 * dT * fT) * (V - E_Ca)
dot(Ca) = -I_Ca / (0.002 * 96486 * 3500) - 0.31705 * Ca^1.34
I_Na = 3 * m * h * (V - RTF * log(137 / 10))
I_BK = (45.7 + 1.1 * 13) / (1 + exp(-V / 17 - 2 * log(Ca / 0.001))) * (V - E_K)
I_K = (35 * xr1 * xr2 + 9 * xa1 * xa2 + 0.0144) * (V - E_K)
I_NS = 50 * ns / (1 + (Ca / 0.0002)^-4) / (1 + 0.01 / 0.00001) * (V + 28)
local = time - 98
plateau = 1.3 * 59 / (1 + exp((local - 8000) / 1000))
decay = 1.3 * 37.25 / (1 + exp((local - 8000) / 150))
I_ICC = piecewise(local < 98, 1.3 * 59, local <= 7582, plateau, local < 10000, decay, 0)
dot(V) = -(I_Na + I_Ca + I_BK + I_K + I_NS - I_ICC) / 77
"""


def slow_wave(time: float) -> float:
    """The current from the interstitial cells of Corrias & Buist's protocol [uA/cm^2] over the first 20 s, in ms."""
    import math

    local = time - 98.0
    if local < 98.0:
        current = 1.3 * 59.0
    elif local <= 7582.0:
        current = 1.3 * 59.0 / (1.0 + math.exp((local - 8000.0) / 1000.0))
    elif local < 10000.0:
        current = 1.3 * 37.25 / (1.0 + math.exp((local - 8000.0) / 150.0))
    else:
        current = 0.0
    return current / 77.0
