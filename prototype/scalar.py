import json
from nonsmooth.proofs.checker import lyapunov as L, statements as S
from nonsmooth.proofs.checker.cells import read_system
from writer import Finder, NotShown
def go(rhs, surfaces, V="z", verdict="asymptotically stable", direction=None, level=None, within="1"):
    sub={"states":["x"],"rhs":[[r] for r in rhs],"at":["0"]}
    own={"within":within,"function":V,"surfaces":surfaces,"empty":[],"proofs":{}}
    ly=L.Lyapunov(read_system(sub),own); ly.proofs=Finder(20000)
    try:
        ly.show_zero()
        if direction is None: ly.show_positive()
        ly.show_falls("",ly.zero,strict=verdict!='stable')
        if level: 
            from fractions import Fraction
            ly.show_border(Fraction(level))
    except NotShown as e: return 'not shown '+str(e)
    own["proofs"]=ly.proofs.found
    if direction: ent={"theorem":"instability","hypotheses":{"direction":direction,"lyapunov":own}}
    else: ent={"theorem":"lyapunov","hypotheses":{"verdict":verdict,"everywhere":False,"level":level,"rate":None,"lyapunov":own}}
    c={"version":S.VERSION,"statement":{"subject":sub,"claims":[{"stability":verdict if not direction else "unstable"}]},"evidence":[ent]}
    return S.refusal(c,len(json.dumps(c))) or 'OK'
print(go(["-sign(x)"],["x"],"x**2"))
print(go(["-x**3+x**4"],["x"],"x**2",within="1/2",level="1/4"))
print(go(["-sign(x)*x**2"],["x"],"x**2"))
print(go(["x**2"],["x"],"-x*Abs(x)",verdict="unstable",direction=["1"]))
print(go(["-x","-x**3"],["x"],"x**2"))
print(go(["Max(x,0)-relu(x)-relu(-x)"],["x"],"x**2",verdict="stable"))
