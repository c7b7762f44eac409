import sys,time,json,traceback
sys.path[:0]=['/tmp','/tmp/certs']
from pathlib import Path
from nonsmooth.proofs.systems.system_stability import *
import nonsmooth.proofs.systems.system_stability as SS
from nonsmooth.symbolic.files.system_file import build_system
from tests.proofs.system_families import families
from writer import write, NotShown
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.systems.system_certificate import build_system_certificate, NoCertificateError, with_stated_function
decide=SS.system_check
pick=[int(x) for x in sys.argv[1:]]
n={}
for i,k in enumerate(families()):
    if pick and i not in pick: continue
    system=build_system({"system":{"states":["x","y"],"rhs":list(k.rhs)},"check":dict(k.check)},"t",Path("t.toml"))
    t0=time.time(); r=decide(system); t1=time.time()
    try:
        o='skip'
        if False: old=build_system_certificate(r); o='old'
    except NoCertificateError as e: o='none:'+str(e)[-40:]
    except Exception as e: o='ERR '+str(e)[:50]
    t2=time.time()
    try:
        if r.proving is None or str(r.method)=='invariance principle': raise NotShown('method '+str(r.method))
        c,kinds=write(r); t3=time.time()
        size=len(json.dumps(c)); why=refusal(c,size); t4=time.time()
        res=('OK' if not why else 'REFUSED '+why, kinds, size, round(t3-t2,2), round(t4-t3,2))
    except NotShown as e: res=('not shown',str(e)[:60])
    except Exception as e:
        res=('ERR',repr(e)[:120]); 
        if pick: traceback.print_exc()
    n[res[0].split()[0]]=n.get(res[0].split()[0],0)+1
    print(i,k.name,'|',r.verdict,'|',str(r.method),'| decide',round(t1-t0,2),o,round(t2-t1,2),'|',*res,flush=True)
print(n)
